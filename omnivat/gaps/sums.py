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
    """Sums over the added rows, for each cell: a class in a domain that has pairs.

    cells    "vis", "tac", "pair" -> (K, W) float64, in the order in which the K cells appeared
    sizes    (K,) float64, pairs of each cell
    squares  the same names -> () sum of squared lengths; a row of zeros stays zero
    own      () sum of the cosines between the two rows of each contact
    """

    def __init__(self, classes: int, domains: int) -> None:
        self.cells: dict[str, Tensor] = {}
        self.sizes = torch.zeros(0, dtype=torch.float64)
        self.squares: dict[str, Tensor] = {}
        self.own = torch.zeros((), dtype=torch.float64)
        self._domains = domains
        self._slots = torch.full((classes * domains,), -1)  # of class * domains + domain
        self._names = torch.zeros(0, dtype=torch.long)  # (K,) that number of each cell

    def add(self, features: Mapping[str, Tensor], labels: Tensor, domains: Tensor) -> None:
        """Add pairs: "vis" and "tac" (B, W) of any length, labels and domains (B,)."""
        parts = zip(features["vis"].split(AT_ONCE), features["tac"].split(AT_ONCE), strict=True)
        for (vis, tac), label, domain in zip(parts, labels.split(AT_ONCE), domains.split(AT_ONCE), strict=True):
            self._add(unit(vis), unit(tac), label * self._domains + domain)

    def _add(self, vis: Tensor, tac: Tensor, cell: Tensor) -> None:
        rows = {"vis": vis, "tac": tac, PAIR: unit((vis + tac) / 2)}
        if not self.cells:
            device = vis.device
            self.sizes, self.own = self.sizes.to(device), self.own.to(device)
            self._slots, self._names = self._slots.to(device), self._names.to(device)
            self.cells = {name: self.own.new_zeros(0, vis.shape[1]) for name in rows}
            self.squares = {name: self.own.clone() for name in rows}
        slots = self._slots_of(cell)
        for name, some in rows.items():
            self.cells[name].index_add_(0, slots, some.double())
            self.squares[name] += some.square().sum().double()
        self.own += (vis * tac).sum().double()
        self.sizes += torch.bincount(slots, minlength=len(self.sizes))

    def _slots_of(self, cell: Tensor) -> Tensor:
        """Return the places (B,) of cells (B,); new cells get places at the end."""
        slots = self._slots[cell]
        if (slots < 0).any():
            new = cell[slots < 0].unique()
            held = len(self._names)
            self._slots[new] = torch.arange(held, held + len(new), device=new.device)
            self._names = torch.cat([self._names, new])
            self.sizes = torch.cat([self.sizes, self.sizes.new_zeros(len(new))])
            for name, sums in self.cells.items():
                self.cells[name] = torch.cat([sums, sums.new_zeros(len(new), sums.shape[1])])
            slots = self._slots[cell]
        return slots

    def centroid_gap(self, domain: int | None = None) -> Tensor:
        """Distance between the mean directions of VIS and TAC, of all pairs or of one domain."""
        every = torch.ones_like(self._names, dtype=torch.bool)
        chosen = every if domain is None else self._names % self._domains == domain
        apart = (self.cells["vis"] - self.cells["tac"])[chosen].sum(0)
        gap: Tensor = (apart / self.sizes[chosen].sum()).norm()
        return gap

    def domain_gap(self, name: str) -> Tensor:
        """Mean distance between the mean directions of two domains; NaN if there is one."""
        sums, sizes = self._groups(name, (0,))
        means = sums / sizes[:, None]
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
        """Return sums (G, W) and sizes (G,) of cells summed over axis 0, the class, or 1, the domain."""
        if not over:
            return self.cells[name], self.sizes
        kinds: dict[tuple[int, ...], Tensor] = {(0,): self._names % self._domains, (1,): self._names // self._domains}
        kept = kinds.get(over, torch.zeros_like(self._names))
        groups, group = kept.unique(return_inverse=True)
        sums = self.cells[name].new_zeros(len(groups), self.cells[name].shape[1])
        sizes = self.sizes.new_zeros(len(groups))
        return sums.index_add_(0, group, self.cells[name]), sizes.index_add_(0, group, self.sizes)


def _less(every: tuple[Tensor, Tensor], left_out: tuple[Tensor, Tensor]) -> tuple[Tensor, Tensor]:
    return every[0] - left_out[0], every[1] - left_out[1]


def _margin(same: tuple[Tensor, Tensor], total: tuple[Tensor, Tensor]) -> Tensor:
    different = _less(total, same)
    return same[0] / same[1] - different[0] / different[1]
