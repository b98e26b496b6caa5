"""What the simulator's tests share."""

import pytest

from omnivat.cli import main
from simulator.__main__ import COMMANDS


@pytest.fixture
def run(capsys):
    """Return a function that runs a command, checks its exit code, and returns its output."""

    def of(*words, code=0):
        try:
            ended = main(list(map(str, words)), commands=COMMANDS, program="simulator")
        except SystemExit as stop:
            ended = stop.code
        said = capsys.readouterr()
        assert ended == code, said.err
        assert "Traceback" not in said.err
        return said

    return of
