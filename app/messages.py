"""Sentences for people: what an error says in the page, and where its traceback goes."""

import logging
from collections.abc import Awaitable, Callable
from functools import wraps

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from app.state import ForgottenError
from omnivat.errors import OmniVatError

log = logging.getLogger(__name__)

Handler = Callable[[Request], Awaitable[Response]]

UNEXPECTED = (
    "Something went wrong on our side; the server's log says what. "
    "The page still works: try again, or choose another pair."
)


def refusal(sentence: str, status: int = 400) -> JSONResponse:
    """Return the answer that the page shows as one sentence."""
    return JSONResponse({"error": sentence}, status_code=status)


def in_sentences(handler: Handler) -> Handler:
    """Answer every error of `handler` with a sentence; log the traceback of unexpected ones."""

    @wraps(handler)
    async def answered(request: Request) -> Response:
        try:
            return await handler(request)
        except OmniVatError as error:
            log.info("%s refused: %s", request.url.path, error)
            return refusal(str(error), 410 if isinstance(error, ForgottenError) else 400)
        except Exception:
            log.exception("%s failed", request.url.path)
            return refusal(UNEXPECTED, 500)

    return answered
