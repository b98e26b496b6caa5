"""The log under a flood: few lines, and short ones."""

import logging

from app.serving import server as logs


def said(caplog, minute, monkeypatch):
    monkeypatch.setattr(logs, "monotonic", lambda: 60.0 * minute)
    return [record.getMessage() for record in caplog.records]


def test_a_flood_of_lines_is_cut_for_a_minute(caplog, monkeypatch):
    log = logging.getLogger("flood")
    log.addFilter(logs.Bounded())
    said(caplog, 1, monkeypatch)
    for number in range(1000):
        log.warning("line %d", number)
    assert len(caplog.records) == logs.LINES
    assert "leaves out the rest" in caplog.records[-1].getMessage()
    said(caplog, 1.99, monkeypatch)
    log.warning("in the same minute")
    assert len(caplog.records) == logs.LINES
    said(caplog, 2, monkeypatch)
    log.warning("one more")
    assert caplog.records[-1].getMessage() == "one more"


def test_a_line_is_short_and_one_line_and_keeps_its_traceback(caplog):
    log = logging.getLogger("broken")
    log.addFilter(logs.Bounded())
    try:
        raise ValueError("no\nway" * 1000)
    except ValueError as error:
        log.exception("failed: %s", error)
    (record,) = caplog.records
    assert record.exc_info and len(record.getMessage()) <= logs.LONGEST
    assert "\n" not in record.getMessage()
