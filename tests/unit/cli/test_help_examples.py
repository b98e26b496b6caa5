"""The example that each command's help ends with."""

import pytest

from omnivat import cli
from omnivat.head.heads import EXAMPLES as SHIPPED

# the others take longer, or need files of one's own; the README's test parses such lines, too
QUICK = ("fetch", "predict", "embed", "dots", "sensor", "evaluate", "profile", "teach", "gaps")


@pytest.mark.parametrize("name", cli.SUMMARIES)
def test_a_help_is_a_whole_sentence_and_an_example_that_the_command_takes(name, capsys):
    with pytest.raises(SystemExit):
        cli.main([name, "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert cli.SUMMARIES[name] in said
    assert said.endswith(f"Example: python -m omnivat {name} {cli.EXAMPLES[name]}".strip())
    cli.parser().parse_args([name, *cli.EXAMPLES[name].split()])


@pytest.mark.slow
@pytest.mark.parametrize("name", QUICK)
def test_the_example_runs_on_the_shipped_files(name, tmp_path, monkeypatch):
    (tmp_path / "examples").symlink_to(SHIPPED)
    monkeypatch.chdir(tmp_path)
    assert cli.main([name, *cli.EXAMPLES[name].split()]) == 0
