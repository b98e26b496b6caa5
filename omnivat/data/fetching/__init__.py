"""Real data sets of others, brought to this machine on request, as folders of pairs.

`sets.json` lists them, with their terms. Nothing of them is part of this project.
"""

import json
import os
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from omnivat.data.fetching.archive import Folder, unpacked, zipped
from omnivat.data.fetching.heights import drawn, load_heights
from omnivat.data.fetching.hub import from_hub
from omnivat.data.fetching.layouts import LAYOUTS, ROWS, Box, Item, spaced
from omnivat.data.fetching.repository import DamagedError, Repository
from omnivat.data.images import read_image
from omnivat.data.recordings.stored import stored_clips
from omnivat.data.recordings.tracks import Film
from omnivat.data.recordings.writing import moments, plain, write_pairs
from omnivat.data.rest import REST
from omnivat.kit.errors import DataError, SettingsError, WriteError
from omnivat.kit.files import (
    read_whole,
    replacing_folder,
    write_csv,
    write_json,
    write_text,
    writing,
)
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.tables import entry, need

TABLE = Path(__file__).with_name("sets.json")
RECORD_BYTES = 4_000_000
RECORD, TERMS = "fetched.json", "TERMS.txt"  # beside the pairs
COLUMNS = ("vis", "tac", "domain", "material", "object", "split", "named", "vis_from", "tac_from")
CLIPS, PICKLE = (".mov", ".mp4"), ".pkl"
KEPT = ("name", "title", "sensor", "terms", "terms_from", "commit", "authors", "changes", "licence")


@dataclass(frozen=True, slots=True, kw_only=True)
class FetchedSet:
    """A row of the table. `pairs` is 0 if unknown; `terms` are the authors' words, "" where they
    gave none.
    """

    name: str
    title: str
    sensor: str
    what: str
    pairs: int
    megabytes: int  # to download
    terms: str
    terms_from: str
    source: str
    commit: str
    authors: str
    files: tuple[str, ...]  # patterns of the files that are needed
    changes: str
    licence: str = ""  # "NAME, URL" of one that lets the pictures be passed on

    @property
    def said(self) -> str:
        """The terms in one line."""
        return f"{self.terms or 'none stated'} ({self.terms_from})"


@cache
def fetched_sets() -> dict[str, FetchedSet]:
    """Return name -> set, in the order of the table."""
    rows = json.loads(TABLE.read_text(encoding="utf-8"))
    return {row["name"]: FetchedSet(**{**row, "files": tuple(row["files"])}) for row in rows}


def fetch(name: str, out: Path, *, source: str = "", on_step: OnStep = ignore) -> Path:
    """Bring the set `name` and return `out`, a new folder of pairs with `pairs.csv` and its terms.

    source  a URL or path of another copy of the repository; "": the authors'

    A later call goes on where an earlier one stopped. Returns at once if `out` already holds the
    set. Pairs whose files a copy on this machine lacks are left out; the record names the files.
    Raises MissingNameError for an unknown name; DataError, WriteError or MissingPackageError, in
    one sentence, if the set does not arrive. `out` appears when it is complete.
    """
    wanted = entry(fetched_sets(), name, kind="set")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        if set_in(out) == wanted:
            return out
        raise WriteError(
            f"'{out}' exists and is not {name} as it is now; name a new folder with --out."
        )
    if any(pattern.endswith(CLIPS) for pattern in wanted.files):
        need("av", purpose=f"the films of {name}")
    part = out.absolute().with_name(f".{out.absolute().name}.part")
    if part.is_symlink():
        raise WriteError(f"'{part}' is a link; remove it, or name another folder with --out.")
    with writing(out):
        part.mkdir(parents=True, exist_ok=True)
        for place, inner, files in os.walk(part):
            for own in (Path(place, each) for each in inner + files):
                if own.is_symlink():  # of another person, it may lead anywhere
                    own.unlink()
    free, need_mb = shutil.disk_usage(part).free // 1_000_000, 2 * wanted.megabytes
    if free < need_mb and not source:
        raise WriteError(
            f"{name} needs {need_mb:,} MB while it is fetched, and '{part.parent}' has {free:,} MB"
            " free."
        )
    if "/datasets/" in wanted.source:
        _from_hub(wanted, out, part, source, on_step)
    else:
        clone = part / "repository"
        resumed = clone.exists()
        try:
            _from_git(wanted, out, clone, source, on_step)
        except DamagedError:
            if not resumed:
                raise
            shutil.rmtree(clone)
            _from_git(wanted, out, clone, source, on_step)
    shutil.rmtree(part, ignore_errors=True)
    return out


def set_in(folder: Path) -> FetchedSet | None:
    """Return the set that a folder holds at the commit of the table; None for anything else."""
    try:
        record = json.loads(read_whole(folder / RECORD, RECORD_BYTES))
        known = fetched_sets()[str(record["name"])]
        return known if record["commit"] == known.commit else None
    except (DataError, ValueError, LookupError, TypeError, RecursionError):
        return None


def _from_git(wanted: FetchedSet, out: Path, clone: Path, source: str, on_step: OnStep) -> None:
    repository = Repository(source or wanted.source, wanted.commit, clone)
    hashes = repository.files(wanted.files)

    def bring(paths: Iterable[str]) -> list[str]:
        lacking = repository.bring({hashes[path] for path in paths}, on_step)
        return [path for path in paths if hashes[path] in lacking]

    def text(path: str) -> str:
        if path not in hashes or bring([path]):
            raise DataError(f"'{source}' lacks the file {path}; name another copy with --from.")
        return next(repository.contents({path: hashes[path]}))[1].decode(errors="replace")

    listed = _once(LAYOUTS[wanted.name](list(hashes), text), hashes)
    lacking = bring(sorted({path for item in listed for path in (item.vis, item.tac) if path}))
    items = [item for item in listed if item.vis not in lacking and item.tac not in lacking]
    if not items:
        place = f"{wanted.commit[:7]}: it lacks {len(lacking)} files"
        raise DataError(f"'{source or wanted.source}' has no pairs of {wanted.name} at {place}.")
    needed = {path: hashes[path] for item in items for path in (item.vis, item.tac) if path}
    _save(wanted, out, items, repository.contents, source, on_step, needed, len(listed), lacking)


def _save(
    wanted: FetchedSet,
    out: Path,
    items: Sequence[Item],
    contents: Callable[[Mapping[str, str]], Iterable[tuple[str, bytes]]],
    source: str,
    on_step: OnStep,
    hashes: Mapping[str, str] | None = None,
    listed: int = 0,
    lacking: Sequence[str] = (),
) -> None:
    """Write a folder of pairs with its table, terms and record; `contents` reads files by their
    paths and hashes.
    """
    paths = (path for item in items for path in (item.vis, item.tac, item.rest) if path)
    needed = hashes or {path: path for path in paths}
    with replacing_folder(out) as work:
        rows = _written(items, contents(needed), len(needed), work, on_step)
        write_csv(work / "pairs.csv", COLUMNS, rows)
        _write_terms(wanted, work, source, len(items), listed or len(items), lacking)


def _once(items: Iterable[Item], hashes: Mapping[str, str]) -> list[Item]:
    """Return the items without those whose touch, by its hash, occurred before."""
    seen = {hashes[item.tac]: item for item in reversed(list(items))}
    return list(reversed(seen.values()))


def _written(
    items: Sequence[Item],
    contents: Iterable[tuple[str, bytes]],
    count: int,
    work: Path,
    on_step: OnStep,
) -> list[list[str]]:
    """Write the pictures of all items into `work`; return the rows of the table of pairs."""
    uses: dict[str, list[tuple[str, Box | None]]] = {}
    rows = []
    for number, item in enumerate(items):
        stem = "/".join(
            (plain(item.domain), plain(item.material), f"{plain(item.object)}-{number:04d}")
        )
        names = {}
        halves = {"vis": item.vis, "tac": item.tac} if item.vis else {"tac": item.tac}
        for (half, path), box in zip(halves.items(), item.boxes or (None, None), strict=False):
            suffix = Path(path).suffix
            made = box or suffix in (*CLIPS, PICKLE)
            names[half] = f"{stem}_{half}{'.png' if made else suffix}"
            uses.setdefault(path, []).append((names[half], box))
        if item.rest:
            rest = f"{stem.rpartition('/')[0]}/{REST}"
            if (rest, None) not in uses.setdefault(item.rest, []):
                uses[item.rest].append((rest, None))
        files = [names["vis"] if item.vis else "", names["tac"]]
        labels = [item.domain, item.material, item.object, item.split, item.named]
        rows.append([*files, *labels, item.vis or item.tac, item.tac])
    for done, (path, content) in enumerate(contents):
        on_step(Step(done=done, total=count, text="pictures"))
        for name, box in uses[path]:
            target = work / name
            target.parent.mkdir(parents=True, exist_ok=True)
            _write_picture(path, content, box, target)
    return rows


def _write_picture(path: str, content: bytes, box: Box | None, target: Path) -> None:
    """Write a file as a picture: itself, a part of it, the moment of contact of a clip, or a
    drawn height map.
    """
    kind = Path(path).suffix
    if kind == PICKLE:
        drawn(load_heights(content, path)).save(target)
    elif kind in CLIPS:
        film = target.with_suffix(kind)
        film.write_bytes(content)
        try:
            track = Film(file=film)
            (moment,) = moments({"tac": track}, None, 1, "contact")["tac"]
            (picture,) = track.pictures([moment])
            picture.save(target)
        finally:
            film.unlink()
    elif box or target.suffix != kind:
        whole, box = read_image(content, path), box or (0.0, 0.0, 1.0, 1.0)
        left, top, right, bottom = (
            round(share * side) for share, side in zip(box, whole.size * 2, strict=True)
        )
        whole.crop((left, top, right, bottom)).save(target)
    else:
        target.write_bytes(content)


def _from_hub(wanted: FetchedSet, out: Path, part: Path, source: str, on_step: OnStep) -> None:
    """Bring a set of the model hub: pictures in a zip or in folders, rows of Parquet, or an archive
    in parts that is unpacked.
    """
    if source and not Path(source).is_dir():
        raise SettingsError(
            f"{wanted.name} comes from the model hub; --from is a folder with its files."
        )
    name = wanted.source.partition("/datasets/")[2]
    files = Path(source or from_hub(name, wanted.commit, part / "files", wanted.files))
    archives = sorted(files.glob("*.zip*"))
    if wanted.name in ROWS:
        folder = _of_rows(wanted, files, part / "pairs", source, on_step)
    elif wanted.name in LAYOUTS:
        with zipped(archives) if archives else nullcontext(Folder(files)) as store:
            items = list(LAYOUTS[wanted.name](list(store.names), lambda path: ""))
            if not items:
                raise DataError(f"'{source or wanted.source}' has no pairs of {wanted.name} now.")
            _save(wanted, out, items, store.contents, source, on_step)
        return
    else:
        made = unpacked(archives, part / "unpacked", on_step)
        lists = [file for file in made if file.name.startswith("contact_")]
        if not lists:
            raise DataError(f"The archive of '{wanted.source}' has no contact lists, as it had.")
        folder = lists[0].parent
        _write_terms(wanted, folder, source, 0, 0, [])
    with writing(out):
        folder.replace(out)


def _of_rows(wanted: FetchedSet, files: Path, folder: Path, source: str, on_step: OnStep) -> Path:
    """Write some touches of each object, split and domain in Parquet files as a folder of pairs."""
    how = ROWS[wanted.name]
    known: dict[str, Any] = {"vis": "", "tac": ["image"], "classes": (), "columns": how.columns}
    found = [
        replace(clip, object=f"{clip.material} {clip.object}", split=clip.split or "test")
        for file in sorted(files.rglob("*.parquet"))
        for clip in stored_clips(file, domain=how.domain(file.stem), **known)
    ]
    clips = [*spaced(found, lambda clip: (clip.domain, clip.split, clip.object))]
    shutil.rmtree(folder, ignore_errors=True)
    made = write_pairs(clips, folder, on_step=on_step)
    _write_terms(wanted, folder, source, made.pairs, len(clips), [])
    return folder


def _write_terms(
    wanted: FetchedSet, folder: Path, source: str, pairs: int, listed: int, lacking: Sequence[str]
) -> None:
    """Write the record of a set, and its terms for people, beside its pairs."""
    record: dict[str, Any] = {name: getattr(wanted, name) for name in KEPT}
    record |= {"source": source or wanted.source, "pairs": pairs, "lacking": list(lacking)}
    write_json(folder / RECORD, record)
    lines = [
        f"{wanted.title}, by {wanted.authors}",
        f"{source or wanted.source} at {wanted.commit}",
        f"Terms, in the authors' words: {wanted.said}.",
        f"Changes made here: {wanted.changes}.",
    ]
    if wanted.licence:
        lines.append(f"Licence: {wanted.licence}")
    if not wanted.terms:
        lines.append(
            "Without stated terms the pictures may be looked at and measured; do not publish them."
        )
    if lacking:
        lines.append(
            f"{pairs} of {listed} pairs: that copy lacks {len(lacking)} files; {RECORD} names them."
        )
    write_text(folder / TERMS, "\n".join([*lines, ""]))
