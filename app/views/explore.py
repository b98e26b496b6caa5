"""Explore: the whole set on a map that answers while p moves."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from app.components import component
from app.resources import Resources
from app.state import order_from
from omnivat.errors import DataError

if TYPE_CHECKING:
    import numpy as np

TITLE = "Explore"
NEIGHBOURS = 6
BATCH = 256  # pairs a step: bounds the memory of attention over a large set


def build() -> None:
    """Lay the tab out."""
    component("explore")
