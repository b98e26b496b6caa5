"""Tables of the ablations beside the printed figures."""

import json

from omnivat.study.ablations import ABLATIONS, chosen, method_name
from omnivat.study.reports.ablation_report import write_ablations

from .made_records import record


def test_an_ablation_over_several_sources_has_their_average_and_no_empty_columns(tmp_path):
    """Spread over seeds of the mean over sources: 50 and 60 at seed 0, 2 more at seed 1."""
    table = ABLATIONS["fixed_order"]
    found = [
        record(method_name(row), f"{source}-sim", seed, [0.5 + 0.1 * (index % 2) + 0.02 * seed])
        for row in table.rows
        for index, source in enumerate(table.sources)
        for seed in (0, 1)
    ]
    text = write_ablations(found, chosen(("fixed_order",)), tmp_path)
    line = next(x for x in text.splitlines() if x.startswith("| p = 0.3 (fixed)"))
    assert line.endswith("| 56.0 ± 1.4 / 46.0 ± 1.4 | 10 |")
    assert "printed" not in text
    points = json.loads((tmp_path / "fixed_order.json").read_text())
    assert points["0.3"] == [0.51, 0.0141]  # of TAG alone
    assert list(points) == [f"{tenth / 10:g}" for tenth in range(11)]
    assert "mean of 2 sources" in (tmp_path / "fixed_order.svg").read_text()
