"""Real pairs on the shelf of Try a pair: the sets that `python -m omnivat fetch` brought to the
folder where the server runs.

Nothing is fetched here. A picture is served by its name in the last listing, never by a path of a
request. Other machines see only the sets whose licence lets them be passed on.
"""

from dataclasses import asdict
from pathlib import Path

from app.shared.messages import readable
from app.shared.places import ENDINGS
from app.shared.state import Reply
from omnivat.kit.errors import DataError

SHOWN = 12  # pairs of a set, evenly spaced in its table
TOLD = ("name", "title", "authors", "terms", "terms_from", "licence", "source", "changes")


class RealPairs:
    """The fetched sets in `folder`."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        # name -> picture, and whether all may see it
        self._files: dict[str, tuple[Path, bool]] = {}

    def listing(self, *, local: bool) -> Reply:
        """Return the sets with their terms and pairs, and a sentence for each set left out.

        local  whether the visitor sits at this machine
        """
        files: dict[str, tuple[Path, bool]] = {}
        sets: dict[str, Reply] = {}
        left_out = []
        for record in sorted(self._folder.glob("[!.]*/fetched.json")):
            try:
                found, pictures = _read(record.parent)
            except DataError as error:
                left_out.append(readable(f"'{record.parent.name:.40}' is left out: {error}"))
                continue
            sets.setdefault(found["name"], found)
            files |= {name: (file, bool(found["licence"])) for name, file in pictures.items()}
        self._files = files
        seen = [entry for entry in sets.values() if local or entry["licence"]]
        return {"local": local, "sets": seen, "left_out": left_out if local else []}

    def picture(self, name: str, *, local: bool) -> Path:
        """Return a picture of the last listing. Raises DataError for any other name."""
        file, passed_on = self._files.get(name, (None, False))
        if file is None or not (local or passed_on) or not file.is_file():
            raise DataError("There is no such real picture; reload the page.")
        return file


def _read(folder: Path) -> tuple[Reply, dict[str, Path]]:
    """Return a fetched set as the page shows it, and its pictures by name.

    Raises DataError if its files are not those that were fetched.
    """
    from omnivat.data.fetching import set_in
    from omnivat.data.readers import read_pairs

    held = set_in(folder)
    if held is None:
        raise DataError("it is no set as `python -m omnivat fetch` brings it now.")
    pairs = read_pairs(folder, reader="csv").pairs
    shown = dict.fromkeys(pairs[k * len(pairs) // SHOWN] for k in range(SHOWN))
    pictures: dict[str, Path] = {}
    rows = []
    for number, pair in enumerate(shown):
        halves = {"vis": pair.vis, "tac": pair.tac}
        if pair.vis == pair.tac:  # a set of touches alone
            del halves["vis"]
        for file in halves.values():
            inside = file.resolve().is_relative_to(folder.resolve())
            if not inside or file.suffix.lower() not in ENDINGS:
                raise DataError(f"'{file.name:.80}' is no picture inside of it.")
        names = {half: f"{held.name}/{number}/{half}{halves[half].suffix}" for half in halves}
        pictures |= {names[half]: file for half, file in halves.items()}
        rows.append({"class": pair.material, "pictures": names})
    facts = {name: value for name, value in asdict(held).items() if name in TOLD}
    return facts | {"count": len(pairs), "pairs": rows}, pictures
