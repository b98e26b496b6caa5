"""The example that each command's help ends with."""

import pytest

from omnivat import cli
from omnivat.head.heads import EXAMPLES as SHIPPED

# the others take longer, or need files of one's own; the README's lines have their like
QUICK = ("embed", "dots", "profile", "gaps")


@pytest.mark.parametrize("name", cli.SUMMARIES)
def test_a_help_explains_each_argument_and_ends_in_an_example_that_the_command_takes(name, capsys):
    with pytest.raises(SystemExit):
        cli.main([name, "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert cli.SUMMARIES[name] in said
    assert said.endswith(f"Example: python -m omnivat {name} {cli.EXAMPLES[name]}".strip())
    whole = cli.parser()
    whole.parse_args([name, *cli.EXAMPLES[name].split()])
    own = whole._subparsers._group_actions[0].choices[name]
    assert [action.dest for action in own._actions if not action.help] == []


@pytest.mark.parametrize("name", QUICK)
def test_the_example_runs_on_the_shipped_files(name, tmp_path, monkeypatch):
    (tmp_path / "examples").symlink_to(SHIPPED)
    monkeypatch.chdir(tmp_path)
    assert cli.main([name, *cli.EXAMPLES[name].split()]) == 0
