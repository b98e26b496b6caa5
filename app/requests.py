"""Read requests safely: limited bytes, JSON objects, numbers."""

import asyncio
import base64
import json
from collections.abc import AsyncIterator, Mapping
from io import BytesIO
from ipaddress import IPv4Address, ip_address, ip_network
from time import monotonic
from typing import TYPE_CHECKING, Any

from starlette.requests import Request

from app.limits import BODY_S, IDLE_S, MAX_QUESTION_BYTES
from omnivat.errors import DataError

if TYPE_CHECKING:
    from PIL import Image

PREVIEW_SIDE = 320  # pixels of the preview


class TooLargeError(DataError):
    """A body is over its limit."""

    status = 413


class StalledError(DataError):
    """An upload stalled."""

    status = 408


def number_from(text: str | None) -> float | str | None:
    """Return `text` as a number, or unchanged if it is not one."""
    try:
        return float(text) if text else None
    except ValueError:
        return text


def file_name(request: Request) -> str:
    """Return the visitor's name for the uploaded image, shortened, for messages."""
    return request.query_params.get("name", "")[:120] or "the image"


def desk_name(request: Request) -> str:
    """Return the visitor set named in a request; "" for the server's own head and set."""
    return request.query_params.get("set", "")[:64]


def visitor_of(request: Request) -> str:
    """Return the visitor's address; of IPv6 the network, as one visitor has 2^64 addresses.

    Behind a proxy on this machine it is the address that the proxy reports (X-Forwarded-For).
    """
    host = request.client.host if request.client else ""
    try:
        address = ip_address(host.partition("%")[0])
    except ValueError:
        return host
    if isinstance(address, IPv4Address):
        return host
    return str(address.ipv4_mapped or ip_network((address, 64), strict=False))


async def blocks(request: Request, limit: int, what: str) -> AsyncIterator[bytes]:
    """Yield the request's bytes as they arrive, at most `limit`.

    Raises TooLargeError for more bytes, StalledError if the upload stalls or takes too long.
    """
    size, began, stream = 0, monotonic(), aiter(request.stream())
    while True:
        left = BODY_S - (monotonic() - began)
        try:
            block = await asyncio.wait_for(anext(stream), min(IDLE_S, left))
        except StopAsyncIteration:
            return
        except TimeoutError as error:
            raise StalledError(f"{what} did not arrive in time; send it again.") from error
        size += len(block)
        if size > limit:
            raise TooLargeError(f"{what} is larger than {limit / 1e6:.3g} MB; scale it down and try again.")
        yield block


async def question_of(request: Request) -> Mapping[str, Any]:
    """Return the JSON object of a request; raises the errors of `blocks` and `question_from`."""
    content = [block async for block in blocks(request, MAX_QUESTION_BYTES, "The question")]
    return question_from(b"".join(content))


def question_from(content: bytes) -> Mapping[str, Any]:
    """Return the JSON object in `content`. Raises DataError if it is anything else."""
    try:
        question = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise DataError("The request is not JSON; send an object such as {} instead.") from error
    if not isinstance(question, dict):
        raise DataError("The request is not a JSON object; send one such as {} instead.")
    return question


def preview(image: "Image.Image") -> str:
    """Return a small JPEG of the image, upright, as a data URL."""
    small = image.copy()
    small.thumbnail((PREVIEW_SIDE, PREVIEW_SIDE))
    with BytesIO() as handle:
        small.save(handle, "JPEG", quality=85)
        return "data:image/jpeg;base64," + base64.b64encode(handle.getvalue()).decode()
