"""A video file that Chromium's fake camera plays; a test changes what it sees while it runs."""

import numpy as np
from PIL import Image

FRAMES, WIDE, HIGH = 8, 320, 240
NOISE = 1.5  # grey levels, of a camera
HEAD, MARK = f"YUV4MPEG2 W{WIDE} H{HIGH} F20:1 Ip A1:1 C420jpeg\n".encode(), b"FRAME\n"
# For a page before it starts: it keeps its videos, and has Chromium's one camera of a file twice,
# by name.
CAMERAS = """
  window.videos = [];
  const make = document.createElement.bind(document);
  document.createElement = (name, ...more) => {
    const made = make(name, ...more);
    if (name === "video") window.videos.push(made);
    return made;
  };
  const { mediaDevices } = navigator;
  const list = mediaDevices.enumerateDevices.bind(mediaDevices);
  const open = mediaDevices.getUserMedia.bind(mediaDevices);
  const NAMES = ["Webcam", "Sensor"];
  mediaDevices.enumerateDevices = async () =>
    (await list()).filter(({ kind }) => kind === "videoinput").slice(0, 1).flatMap(({ kind }) =>
      NAMES.map((label) => ({ kind, label, deviceId: label })));
  mediaDevices.getUserMedia = ({ video }) => {
    const { exact } = video.deviceId ?? {};
    if (exact && !NAMES.includes(exact)) throw new DOMException("no such camera",
      "OverconstrainedError");
    return open({ video: true });
  };
"""


class FakeSensor:
    """Frames in a .y4m file. Chromium reads each frame anew, so the next one shows what is
    written.
    """

    def __init__(self, file):
        self.file = file
        file.write_bytes(HEAD + FRAMES * (MARK + bytes(WIDE * HIGH * 3 // 2)))

    def see(self, *pictures, page=None):
        """Put pictures (H, W, 3), in turn and with a camera's noise, before the camera.

        Wait until `page` has them; the page needs `CAMERAS` as a script from its start.
        """
        random, frames = np.random.default_rng(0), []
        small = [np.asarray(Image.fromarray(one).resize((WIDE, HIGH)), float) for one in pictures]
        for k in range(FRAMES):
            one = small[k % len(small)]
            frames.append(MARK + _packed(one + random.normal(0, NOISE, one.shape)))
        with self.file.open("r+b") as file:
            file.write(HEAD + b"".join(frames))
        if page is not None:
            page.evaluate(
                """n => Promise.all(window.videos.filter((v) => v.srcObject).map((video) =>
                     new Promise((done) => {
                       const next = () => (n-- > 0 ? video.requestVideoFrameCallback(next)
                         : done());
                       next();
                     })))""",
                2 * FRAMES,
            )


def _packed(picture):
    """Return a picture as planes of Y, Cb and Cr (BT.601, 16 to 235), colours at half size."""
    planes = np.asarray(
        Image.fromarray(picture.clip(0, 255).astype(np.uint8)).convert("YCbCr"), float
    )
    bright = 16 + planes[..., 0] * 219 / 255
    colour = 128 + (planes[..., 1:] - 128) * 224 / 255
    halved = colour.reshape(HIGH // 2, 2, WIDE // 2, 2, 2).mean((1, 3))
    parts = bright, halved[..., 0], halved[..., 1]
    return b"".join(part.round().astype(np.uint8).tobytes() for part in parts)
