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
    """Sums over N pairs, for each cell: a class in a domain that has pairs.

    labels, domains  of the pairs, whose features `add` takes some at a time
    cells    by "vis", "tac" and "pair", (K, W), ascending by class, then domain
    sizes    (K,) pairs of each cell
    squares  by the same names, sum of squared lengths; a row of zeros stays zero
    own      sum of the cosines between the two rows of each contact
    """

    def __init__(self, labels: Int[Tensor, " N"], domains: Int[Tensor, " N"]) -> None:
        most = int(domains.max()) + 1 if len(domains) else 1
        names, self._cell, sizes = (labels * most + domains).unique(
            return_inverse=True, return_counts=True
        )
        self._class, self._domain, self.sizes = names // most, names % most, sizes.double()
        self.cells: dict[str, Float64[Tensor, "K W"]] = {}
        self.squares: dict[str, Float64[Tensor, ""]] = {}
        self.own = self.sizes.new_zeros(())

    def add(self, features: Mapping[str, Float[Tensor, "B W"]], rows: slice = slice(None)) -> None:
        """Add the features of the pairs `rows`: "vis", "tac" or both, of any length."""
        parts = (values.split(AT_ONCE) for values in features.values())
        for some, cell in zip(
            zip(*parts, strict=True), self._cell[rows].split(AT_ONCE), strict=True
        ):
            units = dict(zip(features, map(unit, some), strict=True))
            if len(units) == 2:
                self.own += (units["vis"] * units["tac"]).sum().double()
                units[PAIR] = unit(units["vis"] + units["tac"])
            for name, values in units.items():
                if name not in self.cells:
                    self.cells[name] = self.own.new_zeros(len(self.sizes), values.shape[1])
                    self.squares[name] = self.own.new_zeros(())
                self.cells[name].index_add_(0, cell, values.double())
                self.squares[name] += values.square().sum().double()

    def centroid_gap(self, domain: int | None = None) -> Float64[Tensor, ""]:
        """Return the distance between the mean directions of VIS and TAC, of all pairs or of one
        domain.
        """
        chosen = slice(None) if domain is None else self._domain == domain
        apart = (self.cells["vis"] - self.cells["tac"])[chosen].sum(0)
        gap: Tensor = (apart / self.sizes[chosen].sum()).norm()
        return gap

    def domain_gap(self, name: str) -> Float64[Tensor, ""]:
        """Return the mean distance between mean directions of two domains; NaN if there is one."""
        sums, sizes = self._groups(name, "domain")
        means = sums / sizes[:, None]
        first, second = torch.triu_indices(len(means), len(means), 1, device=means.device)
        gaps: Tensor = (means[first] - means[second]).norm(dim=1)
        return gaps.mean()

    def margin(self, name: str) -> Float64[Tensor, ""]:
        """Return the mean cosine of pairs of the same class minus that of pairs of different
        classes.
        """
        return _margin(self._within(name, "class"), self._within(name, "all"))

    def cross_domain_margin(self, name: str) -> Float64[Tensor, ""]:
        """Return the same, for pairs of rows from different domains: does a class keep its
        direction across sensors?
        """
        same = _less(self._within(name, "class"), self._within(name, "cell"))
        return _margin(same, _less(self._within(name, "all"), self._within(name, "domain")))

    def cross_modal_margin(self) -> Float64[Tensor, ""]:
        """Return the same, for pairs of a VIS row and a TAC row of different contacts."""
        own = self.own, self.sizes.sum()
        return _margin(_less(self._between("class"), own), _less(self._between("all"), own))

    def _within(self, name: str, kind: str) -> Cosines:
        """Return the sum and number of the cosines of different rows of one group, of a kind in
        `_groups`.
        """
        sums, sizes = self._groups(name, kind)
        cosines = (sums.square().sum() - self.squares[name]) / 2
        return cosines, (sizes * (sizes - 1)).sum() / 2

    def _between(self, kind: str) -> Cosines:
        """Return the sum and number of the cosines of every VIS row with every TAC row of its
        group.
        """
        (vis, sizes), (tac, _) = self._groups("vis", kind), self._groups("tac", kind)
        return (vis * tac).sum(), sizes.square().sum()

    def _groups(self, name: str, kind: str) -> tuple[Float64[Tensor, "G W"], Float64[Tensor, " G"]]:
        """Return sums and sizes of groups: the cells of a "class", of a "domain", each "cell",
        or "all".
        """
        of_cell = {
            "class": self._class,
            "domain": self._domain,
            "cell": torch.arange(len(self.sizes), device=self.sizes.device),
            "all": torch.zeros_like(self._class),
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
    """Return the mean cosine of pairs of the same class minus that of pairs of different classes,
    in [-2, 2].

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
    sums = Sums(labels, domains)
    sums.add(features)
    return sums
