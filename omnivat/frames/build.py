"""Build the page's frames: one exact map for each stop of p, and the curves.

Maps show unit rows, as the gaps do, VIS above TAC. PCA is computed at every order, then rotated or
mirrored to match the previous map. UMAP starts each map from the previous one. Nothing is
interpolated.
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

PCA_STOPS, UMAP_STOPS = 128, 21  # PCA: more than 101 round stops and the learned order
DEFAULT_ORDERS = tuple(k / 100 for k in range(101))
# maps, and the largest number of evenly spaced stops of each
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
    """Compute the frames of a set of pairs, one order at a time.

    orders      stops of the slider, in quarter turns, ascending
    maps        "method/stage" -> largest number of stops, evenly spaced with both ends; the page
                shows the nearest one. Raw embedding and raw DFrFT have one map for all stops,
                because the transform is unitary
    measures    curves to compute, for the stages with a map; see docs/gaps.md
    provenance  facts about the head, apart from its learned order: hash, source domain
    Raises SettingsError for an unknown map or order, DataError for too many domains or classes.
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
    for found in walk(model, embeddings, orders, stages=builder.stages, predictions=True):
        builder.add(found)
        text = f"map at order {found.order:.2f}"
        on_step(Step(done=found.index + 1, total=len(orders), text=text))
    return builder.finish({"kind": "moved", "learned_order": model.order, **known})
