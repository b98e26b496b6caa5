"""Small videos of plain greys."""

import numpy as np
import pytest

FPS = 10


def film(file, values, spot=slice(0, 48)):
    """Encode a video whose frames are plain greys, in a spot of them."""
    av = pytest.importorskip("av")
    file.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(file), "w") as container:
        stream = container.add_stream("libx264", rate=FPS, options={"crf": "4", "g": "7"})
        stream.width = stream.height = 48
        stream.pix_fmt = "yuv420p"
        for value in values:
            pixels = np.full((48, 48, 3), 50, np.uint8)
            pixels[spot, spot] = value
            container.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24")))
        container.mux(stream.encode())
