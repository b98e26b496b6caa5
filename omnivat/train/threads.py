"""How many threads a step of training is worth."""

from collections.abc import Iterator
from contextlib import contextmanager

import torch

LIGHT = 128  # widths up to this: products take less time than sharing them out


@contextmanager
def threads_for(width: int) -> Iterator[None]:
    """Let torch use one thread inside for a light head, and as many as it has for a wide one."""
    before = torch.get_num_threads()
    if width > LIGHT or before == 1:
        yield
        return
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
