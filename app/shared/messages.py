"""Error messages of the page; tracebacks go to the log."""

import logging
import re
from collections.abc import Awaitable, Callable
from functools import wraps

from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response

from omnivat.kit.errors import OmniVatError

log = logging.getLogger(__name__)

Handler = Callable[[Request], Awaitable[Response]]

UNEXPECTED = (
    "Something went wrong on the server; its log has the details. "
    "The page still works: try again, or choose another pair."
)

# a path without its last part; not the slash of "tools/list"
PLACE = re.compile(r"(?<!\w)(?:/|[A-Za-z]:\\)(?:[^/\\'\"\n]+[/\\])+")


class CancelledError(OmniVatError):
    """The job was cancelled before it ended."""

    status = 499


class BusyError(OmniVatError):
    """Too many jobs are waiting, or the work took too long."""

    status = 503


class UnexpectedError(OmniVatError):
    """The job failed unexpectedly; the log has the traceback."""

    status = 500


def without_places(sentence: str) -> str:
    """Return a sentence with file names only, so that visitors see no folder of the server.

    >>> without_places("'/srv/ada/heads/one/settings.json' is missing.")
    "'settings.json' is missing."
    >>> without_places("There are tools/list and tools/call.")
    'There are tools/list and tools/call.'
    """
    return PLACE.sub("", sentence)


def refusal(sentence: str, status: int = 400) -> JSONResponse:
    """Return the error response, which the page shows as one sentence."""
    return JSONResponse({"error": readable(sentence)}, status_code=status)


def readable(sentence: str) -> str:
    """Return a sentence as it may be sent: no folder of the server, no half of a surrogate pair."""
    return without_places(sentence).encode("utf-8", "replace").decode()


def status_of(error: Exception) -> int:
    """Return the HTTP status of an error; 400 by default."""
    return int(getattr(error, "status", 400))


def in_sentences(handler: Handler) -> Handler:
    """Turn every error of `handler` into a sentence; log the traceback of unexpected ones."""

    @wraps(handler)
    async def checked(request: Request) -> Response:
        try:
            return await handler(request)
        except (OmniVatError, ClientDisconnect) as error:  # who leaves sees no reply
            log.info("%s refused: %s", request.url.path, error)
            return refusal(str(error), status_of(error))
        except Exception:
            log.exception("%s failed", request.url.path)
            return refusal(UNEXPECTED, 500)

    return checked
