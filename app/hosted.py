"""Settings of a hosting service from the environment: address, host names and framing."""

from collections.abc import Mapping

NAME, PORT = "GRADIO_SERVER_NAME", "GRADIO_SERVER_PORT"
CALLED = ("SPACE_HOST", "OMNIVAT_ALLOW_HOST")  # allowed host names, comma-separated
FRAMED = "SPACE_ID"  # set by a service that frames the page
CACHE = "OMNIVAT_CACHE"


def is_hosted(environ: Mapping[str, str]) -> bool:
    """True if a hosting service starts the page."""
    return bool(environ.get(NAME) or environ.get(FRAMED))


def names(environ: Mapping[str, str]) -> list[str]:
    """Return the host names used by a service."""
    listed = ",".join(environ.get(key, "") for key in CALLED)
    return [name.strip() for name in listed.split(",") if name.strip()]


def keeps_nothing(environ: Mapping[str, str]) -> bool:
    """True if maps go to the temporary folder: a service's disk may be read-only."""
    return is_hosted(environ) and not environ.get(CACHE)
