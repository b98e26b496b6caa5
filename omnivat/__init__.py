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
    # from pairs of images to embeddings
    "read_pairs": "omnivat.data.readers:read_pairs",
    "load_encoder": "omnivat.encoders:load_encoder",
    "embed_pairs": "omnivat.encoders.embed:embed_pairs",
    "Embeddings": "omnivat.data.embeddings:Embeddings",
    "load_embeddings": "omnivat.data.store:load_embeddings",
    "save_embeddings": "omnivat.data.store:save_embeddings",
    "default_embeddings": "omnivat.head.heads:default_embeddings",
    # the head
    "OmniVaT": "omnivat.head.head:OmniVaT",
    "HeadSettings": "omnivat.head.settings:HeadSettings",
    "TrainSettings": "omnivat.training:TrainSettings",
    "train": "omnivat.training:train",
    "load_head": "omnivat.head.checkpoint:load_head",
    "save_head": "omnivat.head.checkpoint:save_head",
    "default_head": "omnivat.head.heads:default_head",
    "predict_embeddings": "omnivat.head.predict:predict_embeddings",
    "profile_of": "omnivat.data.profile:profile_of",
    "Lesson": "omnivat.head.teach:Lesson",
    "taught": "omnivat.head.teach:taught",
    "judged": "omnivat.head.teach:judged",
    # what it is worth
    "measured": "omnivat.measure.known:measured",
    "evaluate": "omnivat.measure.known:evaluate",
    "gap_record": "omnivat.measure.gaps.domain:gap_record",
    "centroid_gap": "omnivat.measure.gaps.centroid:centroid_gap",
    "modality_gap": "omnivat.measure.gaps.centroid:modality_gap",
    "frechet": "omnivat.measure.gaps.frechet:frechet",
    "mmd_rbf": "omnivat.measure.gaps.mmd:mmd_rbf",
    "proxy_a": "omnivat.measure.gaps.proxy_a:proxy_a",
    "twins": "omnivat.measure.twins:twins",
    # to look at; `omnivat.figures` draws what a paper prints
    "sweep": "omnivat.maps.sweep:sweep",
    "read_frames": "omnivat.maps.frames:read_frames",
    "explore": "omnivat.notebook:explore",
}
__all__ = ["__version__", *_PUBLIC]
__getattr__ = late(__name__, _PUBLIC)
