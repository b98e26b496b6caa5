"""The Tree tab's answer."""

import numpy as np
import pytest
import torch

from app.views.tree import answer, groups, layer_records, parents


def test_nodes_and_layers_are_those_of_the_head(resources):
    got = answer(resources, {"vis": "row:5", "tac": "row:5", "order": 0.25})
    model, embeddings = resources.head().model, resources.embeddings()
    vis, tac = (torch.from_numpy(a[5:6].copy()) for a in (embeddings.vis, embeddings.tac))
    with torch.inference_mode():
        out = model(vis, tac, order=0.25, nodes=True)
    norms = [node["norm"] for node in got["nodes"]]
    np.testing.assert_allclose(norms, out.nodes[0].norm(dim=-1), atol=1e-4)
    assert [len(layer["nodes"]) for layer in got["layers"]] == [1, 2, 4]
    assert got["parents"] == [-1, 0, 0, 1, 1, 2, 2]
    for node in got["nodes"]:
        assert sum(node["probabilities"]) == pytest.approx(1, abs=1e-4)


def test_parents_and_groups_are_those_of_the_generator(resources):
    dtg = resources.head().model.dtg
    root = torch.randn(1, resources.head().settings.width)
    grown = dtg.grow(root)
    assert parents("tree", 7)[1:] == [dtg.parent(node) for node in range(1, 7)]
    for group, layer in zip(groups("tree", 7), grown.groups, strict=True):
        torch.testing.assert_close(grown.nodes[:, group.start : group.stop], layer)


@pytest.mark.parametrize("arrangement", ["tree", "series", "parallel", "interpolation", "none"])
def test_every_node_of_every_arrangement_stands_somewhere(arrangement):
    count = 1 if arrangement == "none" else 7
    assert len(parents(arrangement, count)) == count
    assert sorted({node for group in groups(arrangement, count) for node in group}) == list(
        range(count)
    )


def test_nodes_at_right_angles_have_no_nod_loss_and_equal_ones_have():
    apart, alike = torch.eye(2), torch.ones(2, 2)
    assert layer_records(apart[None], [range(2)])[0]["nod"] == 0
    assert layer_records(alike[None], [range(2)])[0]["nod"] == pytest.approx(2**0.5, abs=1e-4)
