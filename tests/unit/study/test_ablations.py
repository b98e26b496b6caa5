"""Ablations: rows that are the paper's, and settings that exist."""

import pytest

from omnivat.cli import main
from omnivat.cli.ablate import planned_rows
from omnivat.data.store import save_embeddings
from omnivat.head.settings import HeadSettings
from omnivat.kit.config import field_names, settings_from
from omnivat.kit.errors import MissingNameError
from omnivat.study.ablations import ABLATIONS, chosen
from omnivat.study.baselines import BASELINES
from omnivat.training import TrainSettings

ROWS = [(name, row) for name, table in ABLATIONS.items() for row in table.rows]


@pytest.mark.parametrize(("name", "row"), ROWS)
def test_every_row_is_of_settings_that_exist(name, row):
    one = ABLATIONS[name].rows[row]
    assert set(one.head) <= set(field_names(HeadSettings))
    assert set(one.train) <= set(field_names(TrainSettings))
    settings_from(HeadSettings, {"classes": ("a", "b"), "input_width": 8, **one.head})
    settings_from(TrainSettings, one.train)
    assert one.base == "omnivat" or one.base in BASELINES


def test_rows_of_several_tables_are_run_once():
    tables = chosen(("components", "generation"))
    runs = planned_rows(tables, (0,), {"width": 16}, {})
    names = [(run.method.name, run.source) for run in runs]
    assert len(names) == len(set(names)) == 2 * (6 + 5 - 2)
    assert all(r.method.head.get("width") == 16 for r in runs if r.method.base == "omnivat")


def test_an_unknown_ablation_is_refused_with_the_nearest():
    with pytest.raises(MissingNameError, match="Did you mean 'components'"):
        chosen(("componets",))


def test_one_command_runs_an_ablation_and_writes_its_table(make_embeddings, tmp_path, capsys):
    pairs = make_embeddings(split=True)
    save_embeddings(tmp_path / "set.safetensors", pairs)
    words = ["ablate", "--embeddings", str(tmp_path / "set.safetensors"), "--seeds", "0"]
    words += ["--out", str(tmp_path / "out"), "--only", "class_token", "--sources", "TAG"]
    words += ["--set", "width=16", "--set", "epochs=1"]
    assert main(words) == 0
    assert "3 runs done" in capsys.readouterr().out
    assert main([*words, "--tables-only"]) == 0
    assert "Global class token" in (tmp_path / "out" / "ablations.md").read_text()
