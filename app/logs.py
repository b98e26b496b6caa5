"""A log that visitors cannot fill: few lines a minute, short, and each traceback once."""

import logging
from threading import Lock
from time import monotonic

from omnivat.errors import printable

LINES, LONGEST, TRACEBACKS = 60, 300, 50  # a minute; characters of a line; of one process


class Bounded(logging.Filter):
    """Lets LINES lines a minute through, and the traceback of one place once."""

    def __init__(self) -> None:
        super().__init__()
        self._lock = Lock()
        self._minute, self._lines = -1, 0
        self._seen: set[tuple[str, int]] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        """Shorten a record; False if the minute has had its lines."""
        minute = int(monotonic() // 60)
        with self._lock:
            self._lines = self._lines + 1 if minute == self._minute else 1
            self._minute = minute
            if self._lines > LINES:
                return False
            if self._lines == LINES:
                record.msg, record.args = "the log leaves out the rest of this minute", ()
            self._once(record)
        record.msg, record.args = printable(record.getMessage())[:LONGEST], ()
        return True

    def _once(self, record: logging.LogRecord) -> None:
        trace = record.exc_info[2] if record.exc_info else None
        while trace is not None and trace.tb_next is not None:
            trace = trace.tb_next
        place = (trace.tb_frame.f_code.co_filename, trace.tb_lineno) if trace else ("", 0)
        if place in self._seen or len(self._seen) >= TRACEBACKS:
            record.exc_info = record.exc_text = None
        self._seen.add(place)


def start() -> None:
    """Write the log of this process to standard error, bounded: its own lines and the server's."""
    bounded, handler = Bounded(), logging.StreamHandler()
    handler.addFilter(bounded)
    form = "%(levelname)s %(name)s: %(message)s"
    logging.basicConfig(level=logging.INFO, format=form, handlers=[handler])
    logging.getLogger("httpx").setLevel(logging.WARNING)
    logging.getLogger("uvicorn.error").addFilter(bounded)  # it has another handler
