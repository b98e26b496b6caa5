"""What the tests of the commands share."""

import pytest

from omnivat.cli import main


@pytest.fixture
def run(capsys):
    """Return a function that runs a command, which ends with `code`, and returns what it said."""

    def of(*words, code=0):
        ended = main(list(map(str, words)))
        said = capsys.readouterr()
        assert ended == code, said.err
        assert "Traceback" not in said.err
        return said

    return of
