"""Build the page's frames: one exact map for each stop of the order, and the curves beside it.

Maps are of rows on the unit sphere, as the gaps are, VIS above TAC. PCA is taken anew at every
order, then turned or mirrored to lie nearest to the map before it; UMAP starts each map from the
one before it. Nothing is ever tweened.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from omnivat.data.store import Embeddings
from omnivat.frames.builder import FrameBuilder, next_map, spread, stacked
from omnivat.frames.records import FrameSet
from omnivat.model.head import OmniVaT
from omnivat.progress import OnStep, Step, ignore
from omnivat.sweep import MEASURES, STAGES, STILL, walk

__all__ = ["build_frames", "next_map", "spread", "stacked"]

PCA_STOPS, UMAP_STOPS = 128, 21  # PCA: 101 round stops and the learned order, with room to spare
DEFAULT_ORDERS = tuple(k / 100 for k in range(101))
# which maps, and at how many evenly spread stops at most
DEFAULT_MAPS: Mapping[str, int] = {
    **{f"pca/{stage}": PCA_STOPS for stage in STAGES},
    "umap/raw": 1,
    "umap/frft": 1,
    "umap/f_hat": UMAP_STOPS,
}


def build_frames(
    model: OmniVaT,
    embeddings: Embeddings,
    *,
    orders: Sequence[float] = DEFAULT_ORDERS,
    maps: Mapping[str, int] = DEFAULT_MAPS,
    measures: Sequence[str] = MEASURES,
    provenance: Mapping[str, Any] | None = None,
    seed: int = 0,
    on_step: OnStep = ignore,
) -> FrameSet:
    """Compute all that the page draws for a set of pairs, one order at a time.

    orders      stops of the slider, in quarter turns, ascending
    maps        "method/stage" -> how many stops it has at most, spread evenly with both ends;
                the slider snaps to the nearest of them. Raw embedding and raw DFrFT have one map
                for all stops: the transform is unitary
    measures    curves to compute, for the stages that have a map; see docs/gaps.md
    provenance  what to write about the head beside its learned order: hash, source domain
    Raises SettingsError for a map or order that cannot be, DataError for sets too large to name.
    """
    known = dict(provenance or {})
    builder = FrameBuilder(
        model.settings,
        embeddings,
        orders=orders,
        maps=maps,
        measures=measures,
        source=str(known.get("source", "")),
        still=STILL,
        seed=seed,
    )
    for found in walk(model, embeddings, orders, stages=builder.stages, answers=True):
        builder.add(found)
        text = f"map at order {found.order:.2f}"
        on_step(Step(done=found.index + 1, total=len(orders), text=text))
    return builder.finish({"kind": "moved", "learned_order": model.order, **known})
