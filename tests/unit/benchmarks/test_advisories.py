"""Advisories against the lock file, without a network."""

import json

import pytest
from packaging.version import Version

from benchmarks.advisories import affected, locked, main, plain, within

LOCK = """pillow==12.2.0 \\
    --hash=sha256:00
Some_Name==1.0
"""


def advisory(name, *events, **more):
    entry = {
        "package": {"ecosystem": "PyPI", "name": name},
        "ranges": [{"type": "ECOSYSTEM", "events": list(events)}],
    }
    return {"id": "TEST-1", "affected": [entry], **more}


def test_a_lock_file_is_read_by_the_names_that_registries_compare():
    assert locked(LOCK) == {"pillow": Version("12.2.0"), "some-name": Version("1.0")}
    assert plain("Some.Name_x") == "some-name-x"


@pytest.mark.parametrize(
    ("version", "inside"),
    [
        *(("0.9", False), ("1.0", True), ("1.4", True), ("1.5", False)),
        *(("2.0", True), ("2.1", True), ("2.2", False)),
    ],
)  # fmt: skip
def test_ranges_are_read_from_introduced_to_fixed_or_last_affected(version, inside):
    events = [
        {"introduced": "1.0"},
        {"fixed": "1.5"},
        {"introduced": "2.0"},
        {"last_affected": "2.1"},
    ]
    assert within(Version(version), events) is inside


def test_an_affected_package_is_named_and_a_withdrawn_advisory_is_not():
    found = locked(LOCK)
    hit = advisory("Pillow", {"introduced": "0"}, {"fixed": "12.3.0"})
    assert list(affected(found, [hit])) == [("pillow", "TEST-1")]
    assert list(affected(found, [{**hit, "withdrawn": "2026-01-01"}])) == []
    assert list(affected(found, [advisory("pillow", {"introduced": "12.3.0"})])) == []


def test_the_command_exits_with_one_where_something_is_affected(tmp_path, capsys):
    (tmp_path / "lock").write_text(LOCK)
    hit = advisory("some-name", {"introduced": "0"})
    (tmp_path / "a.json").write_text(json.dumps([hit]))
    call = [str(tmp_path / "a.json"), "--lock", str(tmp_path / "lock")]
    assert main(call) == 1
    assert "some-name 1.0 is affected by TEST-1" in capsys.readouterr().out
