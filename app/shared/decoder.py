"""Decode visitors' images in limited processes; one that takes too long is killed.

The lane of short requests bounds how many decode at once.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.shared.limits import DECODE_S, DECODE_WAIT_S, DECODER_BYTES
from omnivat.kit.limited import Limited
from omnivat.kit.progress import checkpoint

if TYPE_CHECKING:
    from PIL import Image


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A decoded picture, upright RGB, perhaps scaled down, and its original size."""

    image: "Image.Image"
    width: int
    height: int


class Decoder:
    """Reads visitors' images; one instance for the server. `close` ends its processes."""

    def __init__(self) -> None:
        self._limited = Limited(
            "app.shared.decoder:decoded", memory=DECODER_BYTES, seconds=DECODE_S, wait=DECODE_WAIT_S
        )
        self.close = self._limited.close

    def read(self, source: bytes | Path, name: str) -> Picture:
        """Return the picture in bytes or a file. Raises DataError with its `name` for an
        unsupported one.
        """
        from PIL import Image

        from omnivat.data.images import read_bytes

        checkpoint()
        over = (
            f"'{name}' could not be read within the time and memory allowed; scale it down, or"
            " save it as PNG or JPEG."
        )
        found, pixels = self._limited(read_bytes(source, name), over, name=name)
        checkpoint()
        width, height = found["of"]
        image = Image.frombytes("RGB", found["size"], pixels)
        return Picture(image=image, width=width, height=height)


def decoded(content: bytes, *, name: str) -> tuple[dict[str, Any], bytes]:
    """Return the size of a picture, its size in the file, and its pixels."""
    from omnivat.data.images import VISITORS, opened, upright

    picture = opened(content, name, **VISITORS)
    of = picture.size
    image = upright(picture, name)
    if (of[0] > of[1]) != (image.width > image.height):  # it was rotated upright
        of = of[::-1]
    return {"size": image.size, "of": of}, image.tobytes()
