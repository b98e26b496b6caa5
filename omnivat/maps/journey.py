"""Pairs on the map of a set at every stop of p: their positions, their trees' nodes, and what the
head predicts there.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor

from omnivat.data.embeddings import Embeddings
from omnivat.head.checkpoint import Head
from omnivat.head.head import PairCoefficients
from omnivat.kit.errors import DataError
from omnivat.kit.stages import STAGES
from omnivat.maps.frames import FrameSet
from omnivat.maps.frames.builder import UMAP_STOPS, spread, stacked
from omnivat.maps.projection.neighbours import Searched, affine, place_each, placed_by, searched
from omnivat.maps.sweep import walk
from omnivat.measure.gaps.unit import unit

OUTPUT = STAGES[-1]
LINEAR = ("pca",)  # methods whose maps are affine, which places new rows exactly


@dataclass(frozen=True, slots=True, kw_only=True)
class MapStop:
    """The maps of a set's F-hat at one stop, and what places new rows on them."""

    stop: int  # index into the orders of the frames
    order: float
    points: Searched  # unit rows of F-hat (R, D): N of VIS, then N of TAC
    flat: dict[str, Float[Tensor, "R 2"]]  # the map by method
    affine: dict[str, Float[Tensor, "D1 2"] | None]  # by method: the map, if it is linear


@dataclass(frozen=True, slots=True, kw_only=True)
class Journey:
    """B pairs at P stops: positions on each map, predictions of K classes, and N nodes.

    A node's position is that of the F-hat that the pair would have if its tree were that node
    alone; its probabilities are those of the node itself. A head without a tree has N = 0.
    """

    stops: tuple[int, ...]
    orders: tuple[float, ...]
    places: dict[str, dict[str, Float[Tensor, "P B 2"]]]  # method -> modality, in map units
    nodes: dict[str, Float[Tensor, "P B N 2"]]  # method
    exact: dict[str, bool]  # method -> whether the map is linear; else places are estimates
    readings: dict[str, Float[Tensor, "P B K"]]  # class probabilities
    node_probabilities: Float[Tensor, "P B N K"]
    node_lengths: Float[Tensor, "P B N"]


def map_stops(
    head: Head,
    embeddings: Embeddings,
    frames: FrameSet,
    *,
    methods: Sequence[str] = ("umap", "pca"),
    most: int = UMAP_STOPS,
    kept: PairCoefficients | None = None,
) -> Iterator[MapStop]:
    """Yield the maps of a set's F-hat on which `journey` places pairs, at evenly spread stops.

    frames   of this head and these embeddings
    methods  of the maps; one that the frames lack is left out
    most     largest number of stops; they are drawn from those that all these maps have
    kept     coefficients of the embeddings, if they were computed before

    A list of the stops serves any number of journeys; each has 2N rows of F-hat.
    Raises DataError if head, embeddings and frames do not fit, or there is no such map.

    >>> from omnivat import EXAMPLES, default_embeddings, load_embeddings, load_head, read_frames
    >>> head, pairs = load_head(EXAMPLES / "head"), load_embeddings(default_embeddings())
    >>> stops = map_stops(head, pairs, read_frames(EXAMPLES / "frames.bin"), most=2)
    >>> [len(one.points.rows) for one in stops]
    [4320, 4320]
    """
    head.require_embeddings(embeddings)
    if frames.pairs != len(embeddings):
        raise DataError(
            f"The frames are of {frames.pairs} pairs and the embeddings of {len(embeddings)}; "
            "build the frames again with `python -m omnivat sweep`."
        )
    named = {name: frames.maps.get(f"{name}/{OUTPUT}") for name in methods}
    maps = {name: drawn for name, drawn in named.items() if drawn}
    if not maps:
        raise DataError(f"There is no map of {OUTPUT} by {' or '.join(methods)} in these frames.")
    shared = sorted(set.intersection(*(set(drawn.orders) for drawn in maps.values())))
    stops = [shared[place] for place in spread(most, len(shared))]
    orders = [frames.orders[stop] for stop in stops]
    walked = walk(head.model, embeddings, orders, stages=[OUTPUT], predictions=False, kept=kept)
    for stop, found in zip(stops, walked, strict=True):
        points, flat, known = stacked(found.features[OUTPUT]), {}, {}
        for name, drawn in maps.items():
            flat[name] = torch.from_numpy(drawn.places(drawn.orders.index(stop)))
            known[name] = affine(points.double(), flat[name]) if name in LINEAR else None
        yield MapStop(
            stop=stop, order=found.order, points=searched(points), flat=flat, affine=known
        )


@torch.no_grad()
def journey(
    head: Head,
    stops: Iterable[MapStop],
    vis: Float[Tensor, "B W"] | None,
    tac: Float[Tensor, "B W"] | None,
) -> Journey:
    """Return positions, nodes and predictions of B pairs at each stop; the weights stay fixed.

    stops     from `map_stops` of the same head
    vis, tac  raw embeddings; one may be None

    Coefficients are computed once. On a map that is not linear, positions lie between the nearest
    neighbours: for a pair unlike all of the set, they are guesses.

    >>> from omnivat import EXAMPLES, default_embeddings, load_embeddings, load_head, read_frames
    >>> head, pairs = load_head(EXAMPLES / "head"), load_embeddings(default_embeddings())
    >>> stops = list(map_stops(head, pairs, read_frames(EXAMPLES / "frames.bin"), most=3))
    >>> vis, tac = (torch.from_numpy(rows[:1].astype("float32")) for rows in (pairs.vis, pairs.tac))
    >>> found = journey(head, stops, vis, tac)
    >>> found.orders, tuple(found.places["umap"]["vis"].shape), tuple(found.nodes["pca"].shape)
    ((0.0, 0.5, 1.0), (3, 1, 2), (3, 1, 7, 2))
    """
    model = head.model
    kept = model.coefficients(vis, tac)
    pairs, images = torch.arange(len(kept)), kept.names
    through: list[MapStop] = []
    outputs, trees = [], []
    flat: list[dict[str, Tensor]] = []  # (stops, modalities and nodes, B, 2) by method
    # kept stops are one batch; others come and go one by one, as each may hold a large set
    for some in [stops] if isinstance(stops, Sequence) and stops else ([stop] for stop in stops):
        orders = torch.tensor([stop.order for stop in some], dtype=torch.float64)
        orders = orders.repeat_interleave(len(pairs))
        out = model.from_coefficients(kept[pairs.repeat(len(some))], orders, nodes=True)
        bar = torch.stack(list(out.f_bar.values())).mean(0)
        nodes = bar[:, None, :][:, :0] if out.nodes is None else out.nodes
        rows = torch.stack([*out.f_hat.values(), *(bar[:, None] + nodes).unbind(1)])
        queries = unit(rows).unflatten(1, (len(some), -1)).transpose(0, 1).flatten(1, 2)
        flat.append(
            {
                name: placed_at(some, name, queries).unflatten(1, (-1, len(pairs)))
                for name in some[0].flat
            }
        )
        through.extend(some)
        outputs.append(out)
        trees.append(nodes)
    if not flat:
        raise DataError("A journey needs one stop or more; give those of map_stops.")
    whole = {name: torch.cat([each[name] for each in flat]) for name in flat[0]}

    def at_stops(rows: Iterable[Tensor]) -> Tensor:
        every: Tensor = torch.cat(list(rows)).unflatten(0, (len(through), len(pairs)))
        return every

    nodes = at_stops(trees)
    return Journey(
        stops=tuple(stop.stop for stop in through),
        orders=tuple(stop.order for stop in through),
        places={
            method: {name: rows[:, i] for i, name in enumerate(images)}
            for method, rows in whole.items()
        },
        nodes={method: rows[:, len(images) :].transpose(1, 2) for method, rows in whole.items()},
        exact={name: through[-1].affine[name] is not None for name in whole},
        readings={
            name: at_stops(out.reading(name) for out in outputs) for name in outputs[0].readings
        },
        node_probabilities=model.classify(nodes).softmax(-1),
        node_lengths=nodes.norm(dim=-1),
    )


def placed_at(stops: Sequence[MapStop], name: str, queries: Tensor) -> Tensor:
    """Return the places of rows (P, Q, D) on the maps of one method at P stops, (P, Q, 2)."""
    known = [stop.affine[name] for stop in stops]
    if all(linear is None for linear in known):
        return place_each(queries, [stop.points for stop in stops], [s.flat[name] for s in stops])
    return torch.stack(
        [
            placed_by(linear, rows, stop.points, stop.flat[name])
            for linear, rows, stop in zip(known, queries, stops, strict=True)
        ]
    )
