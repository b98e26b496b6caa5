"""Cosine margin: how much closer features of one class are than those of different classes.

Every variant is exact and deterministic in O(N D): for unit rows, the products of all pairs of a
group add up to |S|², where S is the sum of the group. No pairs are sampled and no N×N matrix is
built.
"""

import torch
from torch import Tensor

from omnivat.gaps.unit import unit
from omnivat.shapes import require_shapes


def cosine_margin(features: Tensor, labels: Tensor) -> Tensor:
    """Mean cosine of pairs of the same class minus that of pairs of different classes.

    features  (N, D) any length
    labels    (N,) class of each row, 0 or more
    return    () in [-2, 2]; NaN when there is no pair of one kind

    Source: the paper's margin table, which samples pairs; here all N (N - 1) / 2 are counted.
    """
    require_shapes(features=(features, "N D"), labels=(labels, "N"))
    rows = unit(features)
    return _margin(_pairs(rows, labels), _pairs(rows, torch.zeros_like(labels)))


def cross_domain_margin(features: Tensor, labels: Tensor, domains: Tensor) -> Tensor:
    """The same, for pairs of rows from different domains.

    features  (N, D) any length
    labels    (N,) class of each row; domains  (N,) domain of each row, both 0 or more
    return    () in [-2, 2]; NaN when there is no pair of one kind

    It measures whether a class keeps its direction across sensors.
    """
    require_shapes(features=(features, "N D"), labels=(labels, "N"), domains=(domains, "N"))
    rows = unit(features)
    every = torch.zeros_like(labels)
    cell = labels * (int(domains.max()) + 1 if len(domains) else 1) + domains
    same = _less(_pairs(rows, labels), _pairs(rows, cell))
    total = _less(_pairs(rows, every), _pairs(rows, domains))
    return _margin(same, total)


def cross_modal_margin(vis: Tensor, tac: Tensor, labels: Tensor) -> Tensor:
    """The same, for pairs of a VIS row and a TAC row of different contacts.

    vis, tac  (N, D) any length, row i of both from one contact
    labels    (N,) class of each contact, 0 or more
    return    () in [-2, 2]; NaN when there is no pair of one kind
    """
    require_shapes(vis=(vis, "N D"), tac=(tac, "N D"), labels=(labels, "N"))
    vis, tac = unit(vis), unit(tac)
    own = (vis * tac).sum(), torch.as_tensor(float(len(vis)), dtype=vis.dtype, device=vis.device)
    same = _less(_between(vis, tac, labels), own)
    total = _less(_between(vis, tac, torch.zeros_like(labels)), own)
    return _margin(same, total)


Sums = tuple[Tensor, Tensor]  # sum and number of the cosines of a kind of pairs


def _groups(rows: Tensor, group: Tensor) -> tuple[Tensor, Tensor]:
    """Return the sum (G, D) and the size (G,) of each group."""
    count = int(group.max()) + 1 if len(group) else 1
    sums = rows.new_zeros(count, rows.shape[1]).index_add_(0, group, rows)
    return sums, torch.bincount(group, minlength=count).to(rows.dtype)


def _pairs(rows: Tensor, group: Tensor) -> Sums:
    """Add up the cosines of unordered pairs of different rows inside each group."""
    sums, sizes = _groups(rows, group)
    cosines = (sums.square().sum() - rows.square().sum()) / 2
    return cosines, (sizes * (sizes - 1)).sum() / 2


def _between(vis: Tensor, tac: Tensor, group: Tensor) -> Sums:
    """Add up the cosines of every VIS row with every TAC row of its group."""
    sums, sizes = _groups(vis, group)
    others, _ = _groups(tac, group)
    return (sums * others).sum(), sizes.square().sum()


def _less(all_pairs: Sums, left_out: Sums) -> Sums:
    return all_pairs[0] - left_out[0], all_pairs[1] - left_out[1]


def _margin(same: Sums, total: Sums) -> Tensor:
    different = _less(total, same)
    return same[0] / same[1] - different[0] / different[1]
