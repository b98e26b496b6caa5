"""OmniVaT: single domain generalization for visual-tactile learning, as a library.

Importing this loads nothing heavy; names load on first use.
"""

from omnivat.kit.tables import late

__version__ = "0.1.0"

_PUBLIC = {
    # the transform
    "dfrft": "omnivat.fractional:dfrft",
    "coefficients": "omnivat.fractional:coefficients",
    "synthesise": "omnivat.fractional:synthesise",
    "basis": "omnivat.fractional:basis",
    "FractionalTransform": "omnivat.fractional:FractionalTransform",
    # from pairs of images to embeddings
    "PairSet": "omnivat.data.pairs:PairSet",
    "read_pairs": "omnivat.data.readers:read_pairs",
    "with_rest": "omnivat.data.rest:with_rest",
    # a gel's lamps, and the relief under its colours
    "lamps": "omnivat.data.relief:lamps",
    "slopes": "omnivat.data.relief:slopes",
    "heights": "omnivat.data.relief:heights",
    "with_known_height": "omnivat.data.relief:with_known_height",
    # embeddings
    "load_encoder": "omnivat.encoders:load_encoder",
    "TorchEncoder": "omnivat.encoders.wrapping:TorchEncoder",
    "embed_pairs": "omnivat.encoders.embed:embed_pairs",
    "Embeddings": "omnivat.data.embeddings:Embeddings",
    "import_embeddings": "omnivat.data.foreign:import_embeddings",
    "load_embeddings": "omnivat.data.store:load_embeddings",
    "save_embeddings": "omnivat.data.store:save_embeddings",
    # what is shipped
    "EXAMPLES": "omnivat.head.heads:EXAMPLES",
    "default_embeddings": "omnivat.head.heads:default_embeddings",
    "default_head": "omnivat.head.heads:default_head",
    "twins": "omnivat.measure.twins:twins",
    # the head
    "OmniVaT": "omnivat.head.head:OmniVaT",
    "HeadSettings": "omnivat.head.settings:HeadSettings",
    "TrainSettings": "omnivat.training:TrainSettings",
    "train": "omnivat.training:train",
    "plan_training": "omnivat.training:plan_training",
    "trained_head": "omnivat.training:trained_head",
    "load_head": "omnivat.head.checkpoint:load_head",
    "save_head": "omnivat.head.checkpoint:save_head",
    "predict_pair": "omnivat.head.predict:predict_pair",
    "predict_embeddings": "omnivat.head.predict:predict_embeddings",
    # a new sensor: its profile, lessons, and what more of them would bring
    "profile_of": "omnivat.data.profile:profile_of",
    "profiled": "omnivat.data.profile:profiled",
    "load_profile": "omnivat.data.profile_file:load_profile",
    "save_profile": "omnivat.data.profile_file:save_profile",
    "Lesson": "omnivat.head.teach:Lesson",
    "taught": "omnivat.head.teach:taught",
    "judged": "omnivat.head.teach:judged",
    "curve": "omnivat.head.curve:curve",
    "sensor_card": "omnivat.measure.card.changes:sensor_card",
    # what it is worth
    "measured": "omnivat.measure.known:measured",
    "scored": "omnivat.measure.known:scored",
    "NOTHING": "omnivat.measure.rungs:NOTHING",
    "pairs": "omnivat.measure.rungs:pairs",
    "labels": "omnivat.measure.rungs:labels",
    "unseen_summary": "omnivat.measure.unseen:unseen_summary",
    "ladder": "omnivat.measure.ladder:ladder",
    "try_pairs": "omnivat.study.trial:try_pairs",
    "gap_record": "omnivat.measure.gaps.domain:gap_record",
    "centroid_gap": "omnivat.measure.gaps.centroid:centroid_gap",
    "modality_gap": "omnivat.measure.gaps.centroid:modality_gap",
    "frechet": "omnivat.measure.gaps.frechet:frechet",
    "mmd_rbf": "omnivat.measure.gaps.mmd:mmd_rbf",
    "proxy_a": "omnivat.measure.gaps.proxy_a:proxy_a",
    # to look at
    "sweep": "omnivat.maps.sweep:sweep",
    "build_frames": "omnivat.maps.frames:build_frames",
    "read_frames": "omnivat.maps.frames:read_frames",
    "map_stops": "omnivat.maps.journey:map_stops",
    "journey": "omnivat.maps.journey:journey",
    "explore": "omnivat.notebook:explore",
    "figures": "omnivat.figures",
    # features of any encoder, without a head
    "read_features": "omnivat.study.shift:read_features",
    "write_report": "omnivat.study.shift:write_report",
    "compare": "omnivat.study.comparison:compare",
}
__all__ = ["__version__", *_PUBLIC]
__getattr__ = late(__name__, _PUBLIC)


def __dir__() -> list[str]:
    return __all__
