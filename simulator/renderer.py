"""Mitsuba 3, in scalar mode: without a compiler, with identical images in every run."""

from functools import lru_cache
from typing import Any

from omnivat.kit.tables import need


@lru_cache(maxsize=1)
def mitsuba() -> Any:
    """Return the module. Raises MissingPackageError if it is not installed."""
    module = need("mitsuba", purpose="rendering VIS images")
    module.set_variant("scalar_rgb")
    module.set_log_level(module.LogLevel.Error)
    return module
