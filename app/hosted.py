"""What a hosting service tells a demo by its environment: where to listen, who may call and frame it."""

from collections.abc import Mapping

NAME, PORT = "GRADIO_SERVER_NAME", "GRADIO_SERVER_PORT"
CALLED = ("SPACE_HOST", "OMNIVAT_ALLOW_HOST")  # names, comma-separated, by which it is called
FRAMED = "SPACE_ID"  # set by a service that shows the page inside its own
CACHE = "OMNIVAT_CACHE"


def is_hosted(environ: Mapping[str, str]) -> bool:
    """Whether a service starts the page, rather than a person at this machine."""
    return bool(environ.get(NAME) or environ.get(FRAMED))


def names(environ: Mapping[str, str]) -> list[str]:
    """Return the names by which a service calls the page."""
    told = ",".join(environ.get(key, "") for key in CALLED)
    return [name.strip() for name in told.split(",") if name.strip()]


def keeps_nothing(environ: Mapping[str, str]) -> bool:
    """Whether computed maps go to the temporary folder: a service's disk may be read-only."""
    return is_hosted(environ) and not environ.get(CACHE)
