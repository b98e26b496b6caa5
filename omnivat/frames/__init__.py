"""Frames: the page's data at each stop of p, in one file."""

from typing import Any

from omnivat.frames.file import read_frames, write_frames
from omnivat.frames.records import FrameSet, MapFrames
from omnivat.tables import load as _load

_LATER = {"build_frames": "omnivat.frames.build:build_frames"}  # needs torch; reading does not
__all__ = ["FrameSet", "MapFrames", "build_frames", "read_frames", "write_frames"]


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module 'omnivat.frames' has no attribute {name!r}")
    return _load(_LATER, name, kind="public name")
