"""The log under a flood: few lines, short ones, each different traceback once."""

import logging

from app import server as logs


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
    said(caplog, 2, monkeypatch)
    log.warning("one more")
    assert caplog.records[-1].getMessage() == "one more"


def test_a_line_is_short_and_one_line_and_a_traceback_comes_once(caplog):
    log = logging.getLogger("broken")
    log.addFilter(logs.Bounded())
    for _ in range(3):
        try:
            raise ValueError("no\nway" * 1000)
        except ValueError as error:
            log.exception("failed: %s", error)
    assert [bool(record.exc_info) for record in caplog.records] == [True, False, False]
    for record in caplog.records:
        assert len(record.getMessage()) <= logs.LONGEST
        assert "\n" not in record.getMessage()


def test_a_later_different_error_at_the_same_place_keeps_its_traceback(caplog):
    log = logging.getLogger("different")
    log.addFilter(logs.Bounded())
    for text in ("first", "second", "first"):
        try:
            raise ValueError(text)
        except ValueError:
            log.exception("failed")
    assert [bool(record.exc_info) for record in caplog.records] == [True, True, False]
