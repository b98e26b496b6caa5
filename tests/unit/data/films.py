"""Small videos of plain greys."""

import struct
from fractions import Fraction

import numpy as np
import pytest

FPS = 10
MATRICES = {  # a, b, c, d of a film's display matrix, and what it does to its pictures
    (0, 1, -1, 0): lambda a: np.rot90(a, -1),
    (-1, 0, 0, -1): lambda a: np.rot90(a, 2),
    (-1, 0, 0, 1): np.fliplr,
    (0, 1, 1, 0): lambda a: a.transpose(1, 0, 2),
}


def film(
    file,
    values,
    spot=slice(0, 48),
    *,
    codec="libx264",
    rate=FPS,
    sound=0.0,
    hold=0.0,
    format=None,
    **options,
):
    """Encode a video whose frames are plain greys, in a spot of them.

    sound    seconds of silence in it
    hold     seconds that the last picture is shown; 0: as long as the others
    format   of the container; None: by the file's name
    options  of the container
    """
    av = pytest.importorskip("av")
    file.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(file), "w", format=format, options=options) as container:
        of_codec = {"crf": "4", "g": "7"} if codec == "libx264" else {"g": "7"}
        stream = container.add_stream(codec, rate=rate, options=of_codec)
        stream.width = stream.height = 48
        stream.pix_fmt = "yuv420p"
        stream.bit_rate = 500_000
        voice = container.add_stream("libopus", rate=48_000, layout="mono") if sound else None
        packets = []
        for value in values:
            pixels = np.full((48, 48, 3), 50, np.uint8)
            pixels[spot, spot] = value
            packets += stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24"))
        packets += stream.encode()
        if hold:
            packets[-1].duration = round(hold / packets[-1].time_base)
        container.mux(packets)
        for k in range(int(sound * 50)):
            frame = av.AudioFrame.from_ndarray(np.zeros((1, 960), np.int16), "s16", "mono")
            frame.sample_rate, frame.pts, frame.time_base = 48_000, 960 * k, Fraction(1, 48_000)
            container.mux(voice.encode(frame))
        if voice:
            container.mux(voice.encode())


def turned(file, matrix):
    """Write a display matrix, four signs, into an MP4."""
    content = bytearray(file.read_bytes())
    at = content.find(b"tkhd") + 44
    a, b, c, d = (one << 16 for one in matrix)
    content[at : at + 36] = struct.pack(">9i", a, b, 0, c, d, 0, 0, 0, 1 << 30)
    file.write_bytes(content)
