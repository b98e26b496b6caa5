"""LeRobot data sets with tactile images, in the layouts v2 (a file an episode) and v3 (episodes
joined in files).

https://huggingface.co/docs/lerobot/lerobot-dataset-v3 and its predecessor describe them.
"""

import os
import re
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from omnivat.data.materials import NO_CLASS, class_key
from omnivat.data.naming import cameras_among, checked_split, set_name, split_of
from omnivat.data.parquet import parquet_rows
from omnivat.data.readers.files import number_in, read_labels, read_lines, show
from omnivat.data.recordings.tracks import Clip, Film, Track, stored
from omnivat.kit.errors import DataError
from omnivat.kit.schema import object_in, read_object

INFO = Path("meta") / "info.json"
MOST = 10**9  # files, seconds
MOST_FRAMES = 10**7  # of an episode
MOST_EPISODES = 10**6  # of a split
LACKING = f"It has no number, or no length of 0 to {MOST_FRAMES:,} frames."
PLACE = re.compile(r"{(\w+):?(0?\d{0,2}d?)}")  # in the template of a path


class LeRobot:
    """One data set: its cameras and episodes."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.info = read_object(root / INFO)
        self.version = str(self.info.get("codebase_version", ""))
        if not self.version.startswith(("v2.", "v3.")):
            raise DataError(
                f"'{show(root)}' is a LeRobot data set of version '{show(self.version[:20])}'; v2"
                " and v3 are read."
            )
        self.fps = self._number("fps")
        features = self.info.get("features")
        found = features.items() if isinstance(features, dict) else ()
        self.cameras = {
            name: feature["dtype"]
            for name, feature in found
            if isinstance(feature, dict) and feature.get("dtype") in ("video", "image")
        }

    def _number(self, name: str, other: float = 0) -> float:
        return number_in(
            self.info.get(name, other), 1e-3, 1e6, f"{name} of '{show(self.root / INFO)}'"
        )

    def clips(self, vis: str, tac: Sequence[str], domain: str, labels: Path | None) -> list[Clip]:
        """Return each episode, once for each tactile camera."""
        where = f"'{show(self.root)}'"
        photo, touches, places = cameras_among([*self.cameras], vis, tac, where)
        episodes = self._episodes()
        tasks = {episode.get("task") for episode in episodes}
        table = read_labels(labels, "episode") if labels else {}
        there = {str(episode["episode_index"]) for episode in episodes}
        absent = {"task": "", "problem": "--labels lists this episode, which is not there."}
        episodes += [absent | {"episode_index": name} for name in table if name not in there]
        clips, splits = [], self._splits()
        for episode in episodes:
            number = episode["episode_index"]
            row = table.get(str(number), {})
            if table and not row:
                episode = {"problem": "--labels does not list this episode."} | episode
            for touch, place in zip(touches, places, strict=True):
                task = episode["task"] if len(tasks) > 1 else NO_CLASS
                halves = {half: name for half, name in (("vis", photo), ("tac", touch)) if name}
                clip = Clip(
                    read=partial(self._read, episode, halves),
                    name=f"episode {number} {place}".rstrip(),
                    domain=row.get("domain") or domain or place or set_name(self.root.resolve()),
                    material=class_key(row.get("material") or task) or NO_CLASS,
                    object=row.get("object") or f"episode {number}",
                    split=checked_split(row.get("split", ""), f"--labels, episode {number}")
                    or splits.get(number, ""),
                    cameras=f"photo {photo or 'none'}, touch {touch or 'none'}",
                )
                clips.append(clip)
        return clips

    def _read(
        self, episode: Mapping[str, Any], halves: Mapping[str, str]
    ) -> tuple[dict[str, Track], float]:
        """Return the tracks of an episode, and its length in seconds."""
        if "problem" in episode:
            raise DataError(episode["problem"])
        tracks = {half: self._track(key, episode) for half, key in halves.items()}
        return tracks, episode["length"] / self.fps

    def _episodes(self) -> list[dict[str, Any]]:
        """Return index, length, task and places of each episode; of one that cannot be read, its
        `problem`.
        """
        meta = self.root / "meta"
        if self.version.startswith("v3."):
            rows = [
                row
                for file in sorted((meta / "episodes").rglob("*.parquet"))
                for row in parquet_rows(file)
            ]
        else:
            rows = [_parsed(line) for line in read_lines(meta / "episodes.jsonl") if line]
        found: list[dict[str, Any]] = []
        seen: set[int] = set()
        for line, row in enumerate(rows, start=1):
            number, length = row.get("episode_index"), row.get("length")
            if not (type(number) is type(length) is int and 0 <= length <= MOST_FRAMES):
                number, problem = f"in line {line}", LACKING
                row = {"episode_index": number, "problem": problem}
            elif number in seen:
                row = {"episode_index": number, "problem": "It is listed twice."}
            else:
                seen.add(number)
            found.append(row | {"task": _task(row.get("tasks"))})
        return found

    def _splits(self) -> dict[Any, str]:
        """Return each episode's split, if the data set states several, as "0:80" and "80:99"."""
        stated = self.info.get("splits")
        stated = stated.items() if isinstance(stated, dict) else ()
        spans = {split_of(name): re.fullmatch(r"(\d{1,9}):(\d{1,9})", str(v)) for name, v in stated}
        named = {name: span for name, span in spans.items() if name and span}
        return {
            number: name
            for name, span in named.items()
            for number in range(int(span[1]), min(int(span[2]), int(span[1]) + MOST_EPISODES))
            if len(named) > 1
        }

    def _track(self, key: str, episode: Mapping[str, Any]) -> Track:
        number = episode["episode_index"]
        film = self.cameras[key] == "video"
        place = f"videos/{key}" if film else "data"
        names = {
            "video_key": key,
            "episode_index": number,
            "episode_chunk": number // int(self._number("chunks_size", 1000)),
            **{
                name: int(number_in(episode.get(f"{place}/{name}", 0), 0, MOST, f"{place}/{name}"))
                for name in ("chunk_index", "file_index")
            },
        }
        what = "video_path" if film else "data_path"
        file = self.root / filled(
            self.info.get(what), names, f"{what} of '{show(self.root / INFO)}'"
        )
        if not Path(os.path.realpath(file)).is_relative_to(self.root.resolve()):  # of any links
            raise DataError(
                f"'{show(self.root / INFO)}' leads out of the data set: '{show(file)}'."
            )
        if not film:
            return stored(file, key, number, self.fps)
        start = number_in(episode.get(f"{place}/from_timestamp") or 0.0, 0, MOST, "from_timestamp")
        return Film(file=file, start=start, fps=self.fps)


def _parsed(line: str) -> dict[str, Any]:
    """Return the object in a line of JSON; {} for anything else."""
    try:
        return object_in(line.encode(), "episode")
    except DataError:
        return {}


def _task(tasks: Any) -> str:
    """Return the first task of an episode, which may be a list, a text or missing."""
    first = next(iter(tasks), "") if isinstance(tasks, list) else tasks
    return first if isinstance(first, str) else ""


def filled(template: object, names: Mapping[str, object], what: str) -> str:
    """Return a path template with its places filled: known names, and widths below 100.

    Raises DataError for another name.
    """
    try:
        found = PLACE.sub(lambda place: format(names[place[1]], place[2]), str(template))
        if "\0" in found:
            raise ValueError("no file's name holds it")
        return found
    except (KeyError, ValueError) as error:
        allowed = ", ".join(f"{{{name}}}" for name in names)
        raise DataError(
            f"{what} is '{show(str(template)[:80])}'; it may hold {allowed}, and widths as in"
            " {episode_index:03d}."
        ) from error
