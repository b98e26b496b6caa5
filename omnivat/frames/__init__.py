"""Frames: the page's data at each stop of p, in one file."""

from omnivat.frames.file import read_frames, write_frames
from omnivat.frames.records import FrameSet, MapFrames
from omnivat.tables import late

_LATER = {"build_frames": "omnivat.frames.builder:build_frames"}  # needs torch; reading does not
__all__ = ["FrameSet", "MapFrames", "build_frames", "read_frames", "write_frames"]
__getattr__ = late(__name__, _LATER)
