"""Sums of unit rows by class and domain, from which centroid gaps and margins follow exactly.

For unit rows, the cosines of all pairs of a group add up to |S|², where S is the sum of the group.
Each row is read once, some rows at a time, so sets of any size fit.
"""

from collections.abc import Mapping

import torch
from jaxtyping import Float, Float64, Int
from torch import Tensor

from omnivat.kit.shapes import require_shapes
from omnivat.measure.gaps.unit import unit

AT_ONCE = 256  # rows normalized at once: temporaries stay in the cache
PAIR = "pair"  # the mean direction of a contact's two rows
# sum and number of the cosines of a kind of pairs
Cosines = tuple[Float64[Tensor, ""], Float64[Tensor, ""]]


class Sums:
    """Sums over the added rows, for each cell: a class in a domain that has pairs.

    cells    by "vis", "tac" and "pair", in the order in which the K cells appeared
    sizes    pairs of each cell
    squares  by the same names, sum of squared lengths; a row of zeros stays zero
    own      sum of the cosines between the two rows of each contact
    """

    def __init__(self, classes: int, domains: int) -> None:
        self.cells: dict[str, Float64[Tensor, "K W"]] = {}
        self.sizes: Float64[Tensor, " K"] = torch.zeros(0, dtype=torch.float64)
        self.squares: dict[str, Float64[Tensor, ""]] = {}
        self.own: Float64[Tensor, ""] = torch.zeros((), dtype=torch.float64)
        self._domains = domains
        self._slots = torch.full((classes * domains,), -1)  # of class * domains + domain
        self._names = torch.zeros(0, dtype=torch.long)  # (K,) that number of each cell

    def add(
        self,
        features: Mapping[str, Float[Tensor, "B W"]],
        labels: Int[Tensor, " B"],
        domains: Int[Tensor, " B"],
    ) -> None:
        """Add pairs: "vis", "tac" or both, of any length."""
        for some, cell in zip(
            zip(*(rows.split(AT_ONCE) for rows in features.values()), strict=True),
            (labels * self._domains + domains).split(AT_ONCE),
            strict=True,
        ):
            self._add({name: unit(part) for name, part in zip(features, some, strict=True)}, cell)

    def _add(self, rows: dict[str, Float[Tensor, "B W"]], cell: Int[Tensor, " B"]) -> None:
        both = [*rows.values()]
        if len(both) == 2:
            rows[PAIR] = unit(both[0] + both[1])
        if not self.cells:
            device = cell.device
            self.sizes, self.own = self.sizes.to(device), self.own.to(device)
            self._slots, self._names = self._slots.to(device), self._names.to(device)
            self.cells = {name: self.own.new_zeros(0, some.shape[1]) for name, some in rows.items()}
            self.squares = {name: self.own.clone() for name in rows}
        if (self._slots[cell] < 0).any():  # new cells get places at the end
            new = cell[self._slots[cell] < 0].unique()
            held = len(self._names)
            self._slots[new] = torch.arange(held, held + len(new), device=new.device)
            self._names = torch.cat([self._names, new])
            self.sizes = torch.cat([self.sizes, self.sizes.new_zeros(len(new))])
            for name, sums in self.cells.items():
                self.cells[name] = torch.cat([sums, sums.new_zeros(len(new), sums.shape[1])])
        slots = self._slots[cell]
        for name, some in rows.items():
            self.cells[name].index_add_(0, slots, some.double())
            self.squares[name] += some.square().sum().double()
        if len(both) == 2:
            self.own += (both[0] * both[1]).sum().double()
        self.sizes += torch.bincount(slots, minlength=len(self.sizes))

    def centroid_gap(self, domain: int | None = None) -> Float64[Tensor, ""]:
        """Distance between the mean directions of VIS and TAC, of all pairs or of one domain."""
        every = torch.ones_like(self._names, dtype=torch.bool)
        chosen = every if domain is None else self._names % self._domains == domain
        apart = (self.cells["vis"] - self.cells["tac"])[chosen].sum(0)
        gap: Tensor = (apart / self.sizes[chosen].sum()).norm()
        return gap

    def domain_gap(self, name: str) -> Float64[Tensor, ""]:
        """Mean distance between the mean directions of two domains; NaN if there is one."""
        sums, sizes = self._groups(name, "domain")
        means = sums / sizes[:, None]
        first, second = torch.triu_indices(len(means), len(means), 1, device=means.device)
        gaps: Tensor = (means[first] - means[second]).norm(dim=1)
        return gaps.mean()

    def margin(self, name: str) -> Float64[Tensor, ""]:
        """Mean cosine of pairs of the same class minus that of pairs of different classes."""
        return _margin(self._within(name, "class"), self._within(name, "all"))

    def cross_domain_margin(self, name: str) -> Float64[Tensor, ""]:
        """The same, for pairs of rows from different domains: does a class keep its direction
        across sensors?
        """
        same = _less(self._within(name, "class"), self._within(name, "cell"))
        return _margin(same, _less(self._within(name, "all"), self._within(name, "domain")))

    def cross_modal_margin(self) -> Float64[Tensor, ""]:
        """The same, for pairs of a VIS row and a TAC row of different contacts."""
        own = self.own, self.sizes.sum()
        return _margin(_less(self._between("class"), own), _less(self._between("all"), own))

    def _within(self, name: str, kind: str) -> Cosines:
        """Sum and number of the cosines of different rows of one group, of a kind in `_groups`."""
        sums, sizes = self._groups(name, kind)
        cosines = (sums.square().sum() - self.squares[name]) / 2
        return cosines, (sizes * (sizes - 1)).sum() / 2

    def _between(self, kind: str) -> Cosines:
        """Sum and number of the cosines of every VIS row with every TAC row of its group."""
        (vis, sizes), (tac, _) = self._groups("vis", kind), self._groups("tac", kind)
        return (vis * tac).sum(), sizes.square().sum()

    def _groups(self, name: str, kind: str) -> tuple[Float64[Tensor, "G W"], Float64[Tensor, " G"]]:
        """Return sums and sizes of groups: the cells of a "class", of a "domain", each "cell",
        or "all".
        """
        of_cell = {
            "class": self._names // self._domains,
            "domain": self._names % self._domains,
            "cell": self._names,
            "all": torch.zeros_like(self._names),
        }
        groups, group = of_cell[kind].unique(return_inverse=True)
        sums = self.cells[name].new_zeros(len(groups), self.cells[name].shape[1])
        sizes = self.sizes.new_zeros(len(groups))
        return sums.index_add_(0, group, self.cells[name]), sizes.index_add_(0, group, self.sizes)


def _less(every: Cosines, left_out: Cosines) -> Cosines:
    return every[0] - left_out[0], every[1] - left_out[1]


def _margin(same: Cosines, total: Cosines) -> Float64[Tensor, ""]:
    different = _less(total, same)
    return same[0] / same[1] - different[0] / different[1]


def cosine_margin(features: Float[Tensor, "N D"], labels: Int[Tensor, " N"]) -> Float64[Tensor, ""]:
    """Mean cosine of pairs of the same class minus that of pairs of different classes, in [-2, 2].

    NaN if there is no pair of one kind. The paper's margin table samples pairs; here all are
    counted.

    >>> import torch
    >>> rows = torch.tensor([[1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [0.0, 3.0]])
    >>> float(cosine_margin(rows, torch.tensor([0, 0, 1, 1])))
    1.0
    """
    return sums_of(labels, torch.zeros_like(labels), vis=features).margin("vis")


def sums_of(
    labels: Int[Tensor, " N"], domains: Int[Tensor, " N"], **features: Float[Tensor, "N D"]
) -> Sums:
    """Return the sums of whole sets: "vis", "tac" or both."""
    require_shapes(
        labels=(labels, "N"), domains=(domains, "N"), **{n: (x, "N D") for n, x in features.items()}
    )
    sums = Sums(*(int(index.max()) + 1 if len(index) else 1 for index in (labels, domains)))
    sums.add(features, labels, domains)
    return sums
