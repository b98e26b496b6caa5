"""Frames: the page's data at each stop of p, in one file."""

from omnivat.kit.tables import late
from omnivat.maps.frames.file import read_frames, write_frames
from omnivat.maps.frames.records import FrameSet, MapFrames

# needs torch; reading does not
_LATER = {"build_frames": "omnivat.maps.frames.builder:build_frames"}
__all__ = ["FrameSet", "MapFrames", "build_frames", "read_frames", "write_frames"]
__getattr__ = late(__name__, _LATER)
