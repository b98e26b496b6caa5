"""Draw a progress bar on stderr from reports of progress."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from omnivat.progress import OnStep, Step


@contextmanager
def progress_bar(title: str) -> Iterator[OnStep]:
    """Yield a function that draws progress reports; nothing is drawn if stderr is a file."""
    from tqdm import tqdm

    bar = tqdm(desc=title, disable=not sys.stderr.isatty(), leave=False, dynamic_ncols=True)

    def show(step: Step) -> None:
        if step.total:
            bar.total = step.total
        bar.set_postfix_str(step.text, refresh=False)
        bar.update(step.done - bar.n)

    try:
        yield show
    finally:
        bar.close()
