"""Sums of unit rows by class and domain, from which centroid gaps and margins follow exactly.

For unit rows, the cosines of all pairs of a group add up to |S|², where S is the sum of the group.
Each row is read once, some rows at a time, so sets of any size fit.
"""

from collections.abc import Mapping

import torch
from torch import Tensor

from omnivat.gaps.unit import unit

AT_ONCE = 256  # rows normalized at once: temporaries stay in the cache
PAIR = "pair"  # the mean direction of a contact's two rows


class Sums:
    """Sums over the added rows.

    cells    "vis", "tac", "pair" -> (C, S, W) float64, by class and domain
    sizes    (C, S) float64, pairs of each class and domain
    squares  the same names -> () sum of squared lengths; a row of zeros stays zero
    own      () sum of the cosines between the two rows of each contact
    """

    def __init__(self, classes: int, domains: int) -> None:
        self.cells: dict[str, Tensor] = {}
        self.sizes = torch.zeros(classes, domains, dtype=torch.float64)
        self.squares: dict[str, Tensor] = {}
        self.own = torch.zeros((), dtype=torch.float64)

    def add(self, features: Mapping[str, Tensor], labels: Tensor, domains: Tensor) -> None:
        """Add pairs: "vis" and "tac" (B, W) of any length, labels and domains (B,)."""
        parts = zip(features["vis"].split(AT_ONCE), features["tac"].split(AT_ONCE), strict=True)
        for (vis, tac), label, domain in zip(
            parts, labels.split(AT_ONCE), domains.split(AT_ONCE), strict=True
        ):
            self._add(unit(vis), unit(tac), label * self.sizes.shape[1] + domain)

    def _add(self, vis: Tensor, tac: Tensor, cell: Tensor) -> None:
        rows = {"vis": vis, "tac": tac, PAIR: unit((vis + tac) / 2)}
        if not self.cells:
            self.sizes, self.own = self.sizes.to(vis.device), self.own.to(vis.device)
            shape = (*self.sizes.shape, vis.shape[1])
            self.cells = {name: self.own.new_zeros(shape) for name in rows}
            self.squares = {name: self.own.clone() for name in rows}
        for name, some in rows.items():
            self.cells[name].flatten(0, 1).index_add_(0, cell, some.double())
            self.squares[name] += some.square().sum().double()
        self.own += (vis * tac).sum().double()
        self.sizes += torch.bincount(cell, minlength=self.sizes.numel()).view_as(self.sizes)

    def centroid_gap(self, domain: int | None = None) -> Tensor:
        """Distance between the mean directions of VIS and TAC, of all pairs or of one domain."""
        chosen = slice(None) if domain is None else slice(domain, domain + 1)
        apart = (self.cells["vis"] - self.cells["tac"])[:, chosen].sum((0, 1))
        gap: Tensor = (apart / self.sizes[:, chosen].sum()).norm()
        return gap

    def domain_gap(self, name: str) -> Tensor:
        """Mean distance between the mean directions of two domains; NaN if there is one."""
        sizes = self.sizes.sum(0)
        means = self.cells[name].sum(0)[sizes > 0] / sizes[sizes > 0, None]
        first, second = torch.triu_indices(len(means), len(means), 1, device=means.device)
        gaps: Tensor = (means[first] - means[second]).norm(dim=1)
        return gaps.mean()

    def margin(self, name: str) -> Tensor:
        """Mean cosine of pairs of the same class minus that of pairs of different classes."""
        return _margin(self._within(name, (1,)), self._within(name, (0, 1)))

    def cross_domain_margin(self, name: str) -> Tensor:
        """The same, for pairs of rows from different domains."""
        same = _less(self._within(name, (1,)), self._within(name, ()))
        return _margin(same, _less(self._within(name, (0, 1)), self._within(name, (0,))))

    def cross_modal_margin(self) -> Tensor:
        """The same, for pairs of a VIS row and a TAC row of different contacts."""
        own = self.own, self.sizes.sum()
        return _margin(_less(self._between((1,)), own), _less(self._between((0, 1)), own))

    def _within(self, name: str, over: tuple[int, ...]) -> tuple[Tensor, Tensor]:
        """Sum of cosines of different rows of one group; a group is a sum of cells `over` axes."""
        sums, sizes = self._groups(name, over)
        cosines = (sums.square().sum() - self.squares[name]) / 2
        return cosines, (sizes * (sizes - 1)).sum() / 2

    def _between(self, over: tuple[int, ...]) -> tuple[Tensor, Tensor]:
        """Sum of cosines of every VIS row with every TAC row of its group."""
        (vis, sizes), (tac, _) = self._groups("vis", over), self._groups("tac", over)
        return (vis * tac).sum(), sizes.square().sum()

    def _groups(self, name: str, over: tuple[int, ...]) -> tuple[Tensor, Tensor]:
        if not over:  # `sum` over an empty tuple would sum over all axes
            return self.cells[name], self.sizes
        return self.cells[name].sum(over), self.sizes.sum(over)


def _less(every: tuple[Tensor, Tensor], left_out: tuple[Tensor, Tensor]) -> tuple[Tensor, Tensor]:
    return every[0] - left_out[0], every[1] - left_out[1]


def _margin(same: tuple[Tensor, Tensor], total: tuple[Tensor, Tensor]) -> Tensor:
    different = _less(total, same)
    return same[0] / same[1] - different[0] / different[1]
