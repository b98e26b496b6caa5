"""Facts about the nodes of a tree."""

import pytest
import torch

from omnivat.head.dtg import DTG, groups, parents


@pytest.mark.parametrize("arrangement", ["tree", "series", "parallel", "interpolation", "none"])
def test_every_node_of_every_arrangement_stands_in_one_group(arrangement):
    count = 1 if arrangement == "none" else 7
    assert len(parents(arrangement, count)) == count
    grouped = [node for group in groups(arrangement, count) for node in group]
    assert sorted(grouped) == list(range(count))


@pytest.mark.parametrize("arrangement", ["tree", "series", "parallel"])
def test_nodes_grow_from_their_parents(arrangement):
    torch.manual_seed(0)
    dtg = DTG(4, 2, arrangement)
    nodes = dtg.grow(torch.randn(3, 4)).nodes
    for node, parent in enumerate(parents(arrangement, 3)[1:]):
        grown = nodes[:, parent] @ dtg.weight[node].T + dtg.bias[node]
        torch.testing.assert_close(nodes[:, node + 1], grown)
