"""How many threads of torch a call gets: sharing out little work costs more than it saves."""

from collections.abc import Iterator
from contextlib import contextmanager

import torch

LIGHT = 128  # widths up to this train sooner on one thread
FEW_PAIRS = 4  # and so many pairs are predicted sooner on one


@contextmanager
def one_thread(few: bool = True) -> Iterator[None]:
    """Let torch use one thread inside where there is little work, else as many as it has."""
    before = torch.get_num_threads()
    if not few or before == 1:
        yield
        return
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
