"""The nodes of a pair."""

import numpy as np
import pytest
import torch

from app.explore.nodes import tree, votes


def test_nodes_and_layers_are_those_of_the_head(resources):
    got = tree(resources, {"vis": "row:5", "tac": "row:5", "order": 0.25})
    model, embeddings = resources.head().model, resources.embeddings()
    vis, tac = (torch.from_numpy(a[5:6].copy()) for a in (embeddings.vis, embeddings.tac))
    with torch.inference_mode():
        out = model(vis, tac, order=0.25, nodes=True)
    norms = [node["norm"] for node in got["nodes"]]
    np.testing.assert_allclose(norms, out.nodes[0].norm(dim=-1), atol=1e-4)
    assert [len(layer["nodes"]) for layer in got["layers"]] == [1, 2, 4]
    for node in got["nodes"]:
        assert sum(node["probabilities"]) == pytest.approx(1, abs=1e-4)


def test_a_node_that_gives_one_class_to_every_pair_is_found(resources):
    got = votes(resources, {})
    assert got["pairs"] == len(resources.embeddings())
    model, embeddings = resources.head().model, resources.embeddings()
    with torch.inference_mode():
        out = model(
            torch.from_numpy(embeddings.vis.copy()),
            torch.from_numpy(embeddings.tac.copy()),
            nodes=True,
        )
        given = model.classify(out.nodes).argmax(-1)
    for node, vote in enumerate(got["votes"]):
        name = resources.head().settings.classes.index(vote["class"])
        assert (given[:, node] == name).double().mean() == pytest.approx(vote["share"], abs=1e-4)
        assert vote["share"] >= 1 / 5


def test_the_nodes_of_a_large_set_are_those_of_some_of_its_pairs(resources, monkeypatch):
    monkeypatch.setattr("app.explore.nodes.MOST_PAIRS", 7)
    assert votes(resources, {})["pairs"] == 7
