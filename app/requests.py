"""Reading a request with care: no more bytes than allowed, JSON that is an object, numbers."""

import base64
import json
from collections.abc import Mapping
from io import BytesIO
from typing import TYPE_CHECKING, Any

from starlette.requests import Request

from omnivat.errors import DataError

if TYPE_CHECKING:
    from PIL import Image

PREVIEW_SIDE = 320  # pixels of the picture that shows what the model sees


def number_from(text: str | None) -> float | str | None:
    """Return the number that `text` writes; the text itself where it writes none."""
    try:
        return float(text) if text else None
    except ValueError:
        return text


def file_name(request: Request) -> str:
    """Return what a visitor calls the image that is sent, shortened, for messages."""
    return request.query_params.get("name", "")[:120] or "the image"


async def body(request: Request, limit: int, what: str) -> bytes:
    """Return the request's bytes, reading no more than `limit` of them.

    Raises DataError when there are more.
    """
    content = bytearray()
    async for part in request.stream():
        content += part
        if len(content) > limit:
            raise DataError(
                f"{what} is larger than {limit / 1e6:.3g} MB; scale it down and try again."
            )
    return bytes(content)


def question_from(content: bytes) -> Mapping[str, Any]:
    """Return the JSON object in `content`.

    Raises DataError when it is anything else.
    """
    try:
        question = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise DataError("The question is not JSON; send an object such as {} instead.") from error
    if not isinstance(question, dict):
        raise DataError("The question is not a JSON object; send one such as {} instead.")
    return question


def preview(image: "Image.Image") -> str:
    """Return a small JPEG of the image, upright, as a data URL."""
    small = image.copy()
    small.thumbnail((PREVIEW_SIDE, PREVIEW_SIDE))
    with BytesIO() as handle:
        small.save(handle, "JPEG", quality=85)
        return "data:image/jpeg;base64," + base64.b64encode(handle.getvalue()).decode()
