"""LeRobot data sets with tactile images, in the layouts v2 (a file an episode) and v3 (episodes joined in files).

https://huggingface.co/docs/lerobot/lerobot-dataset-v3 and its predecessor describe them.
"""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from omnivat.data.materials import NO_CLASS, class_key
from omnivat.data.readers.files import read_json, read_lines, read_rows, show
from omnivat.data.recordings.tracks import Clip, Track, parquet_rows
from omnivat.kit.errors import DataError

INFO = Path("meta") / "info.json"
WIDE = re.compile(r"\d{3}[^{}]*\}")  # a place of so many letters fills the memory
TOUCH = re.compile(r"tac|touch|gel|digit|finger", re.IGNORECASE)


class LeRobot:
    """One data set: its cameras and episodes."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.info = read_json(root / INFO, dict)
        self.version = str(self.info.get("codebase_version", ""))
        if not self.version.startswith(("v2.", "v3.")):
            raise DataError(
                f"'{show(root)}' is a LeRobot data set of version '{show(self.version[:20])}'; v2 and v3 are read."
            )
        self.fps = self._number("fps")
        features = self.info.get("features")
        found = features.items() if isinstance(features, dict) else ()
        self.cameras = {
            name: one["dtype"]
            for name, one in found
            if isinstance(one, dict) and one.get("dtype") in ("video", "image")
        }

    def _number(self, name: str, other: float = 0) -> float:
        value = self.info.get(name, other)
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < 1e9:
            raise DataError(f"'{show(self.root / INFO)}' has {name} {value!r:.20}; it has to be above 0.")
        return float(value)

    def clips(self, vis: str, tac: Sequence[str], domain: str, labels: Path | None) -> list[Clip]:
        """Return each episode, once for each tactile camera."""
        photo, touches = self._chosen(vis, tac)
        episodes = self._episodes()
        tasks = {one["task"] for one in episodes}
        table = {row["episode"]: row for row in read_rows(labels, ("episode", "material"))} if labels else {}
        clips = []
        for one in episodes:
            number = one["episode_index"]
            own = table.get(str(number), {})
            if table and not own:
                continue
            material = own.get("material") or (one["task"] if len(tasks) > 1 else NO_CLASS)
            for touch in touches:
                wanted = {"vis": photo, "tac": touch} if photo else {"tac": touch}
                several = touch.rpartition(".")[2] if len(touches) > 1 else self.root.resolve().name
                clips.append(
                    Clip(
                        name=f"episode {number}" + (f" {several}" if len(touches) > 1 else ""),
                        tracks={half: self._track(key, one) for half, key in wanted.items()},
                        length=one["length"] / self.fps,
                        domain=own.get("domain") or domain or several,
                        material=class_key(material),
                        object=own.get("object") or f"episode {number}",
                        split=own.get("split", ""),
                    )
                )
        if not clips:
            raise DataError(f"No episode of '{show(self.root)}' is used; check --labels.")
        return clips

    def _chosen(self, vis: str, tac: Sequence[str]) -> tuple[str, list[str]]:
        """Return the camera of photos ("" without one) and those of touches."""
        there = ", ".join(self.cameras) or "none"
        for name in filter(None, (vis, *tac)):
            if name not in self.cameras:
                raise DataError(f"There is no camera '{show(name)}'; there are {show(there)}.")
        touches = list(tac) or [name for name in self.cameras if TOUCH.search(name.rpartition(".")[2])]
        others = [name for name in self.cameras if name not in touches]
        if not touches:
            raise DataError(f"No camera is called tactile; name one with --tac. There are {show(there)}.")
        if not vis and len(others) > 1:
            raise DataError(f"Name the camera of photos with --vis: {show(', '.join(others))}.")
        return vis or (others[0] if others else ""), touches

    def _episodes(self) -> list[dict[str, Any]]:
        """Return index, length, task and places of each episode; raises DataError for odd ones."""
        meta = self.root / "meta"
        if self.version.startswith("v3."):
            rows = [row for file in sorted((meta / "episodes").rglob("*.parquet")) for row in parquet_rows(file)]
        else:
            try:
                rows = [json.loads(line) for line in read_lines(meta / "episodes.jsonl") if line]
            except (ValueError, RecursionError) as error:
                raise DataError(f"'{show(meta / 'episodes.jsonl')}' is not JSON ({error}).") from error
        for row in rows:
            if not isinstance(row, dict) or not all(
                type(row.get(name)) is int and 0 <= row[name] < 10**9 for name in ("episode_index", "length")
            ):
                raise DataError(f"'{show(meta)}' lists an episode without its number or length.")
            row["task"] = _task(row.get("tasks"))
        if not rows:
            raise DataError(f"'{show(meta)}' lists no episodes.")
        numbers = [row["episode_index"] for row in rows]
        if len(set(numbers)) < len(numbers):
            raise DataError(f"'{show(meta)}' lists an episode twice.")
        return rows

    def _track(self, key: str, episode: Mapping[str, Any]) -> Track:
        number = episode["episode_index"]
        film = self.cameras[key] == "video"
        place = f"videos/{key}" if film else "data"
        names = {
            "video_key": key,
            "episode_index": number,
            "episode_chunk": number // int(self._number("chunks_size", 1000)),
            **{name: episode.get(f"{place}/{name}", 0) for name in ("chunk_index", "file_index")},
        }
        template = str(self.info.get("video_path" if film else "data_path"))
        try:
            if WIDE.search(template):
                raise ValueError("a number of a hundred digits or more")
            file = self.root / template.format(**names)
        except (LookupError, ValueError, AttributeError, TypeError) as error:
            raise DataError(f"'{show(self.root / INFO)}' has an odd path '{show(template[:80])}'.") from error
        if not file.resolve().is_relative_to(self.root.resolve()):
            raise DataError(f"'{show(self.root / INFO)}' leads out of the data set: '{show(template[:80])}'.")
        found = Track(file=file, episode=number, fps=self.fps, column="" if film else key)
        start = episode.get(f"{place}/from_timestamp") or 0.0
        if not isinstance(start, int | float) or not 0 <= start < 1e9:
            raise DataError(f"Episode {number} of '{show(self.root)}' starts at '{start!r:.20}'.")
        return replace(found, start=float(start)) if film else found


def _task(tasks: Any) -> str:
    """Return the first task of an episode, which may be a list, an array, a text or missing."""
    if isinstance(tasks, str):
        return tasks
    first = next(iter(tasks), "") if isinstance(tasks, list | tuple) else ""
    return first if isinstance(first, str) else ""
