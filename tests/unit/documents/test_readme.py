"""What the README shows at its start is taken by the commands, and its first Python runs."""

import re
from pathlib import Path

import pytest

from omnivat.cli import parser

ROOT = Path(__file__).resolve().parents[3]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
LINES = re.findall(r"^python -m omnivat (.+)$", TEXT, re.M)


@pytest.mark.parametrize("line", LINES)
def test_every_command_of_the_readme_is_taken_with_its_options(line):
    assert parser().parse_args(line.split()).command == line.split()[0]


def test_the_pair_of_the_readme_is_predicted(capsys):
    code = next(
        block for block in re.findall(r"```python\n(.*?)```", TEXT, re.S) if "pair(" in block
    )
    exec(code, {})  # the README's own text
    assert capsys.readouterr().out.startswith("glass {")
