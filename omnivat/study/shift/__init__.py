"""The domain shift of any features, without a head: gaps, retrieval, neighbours, probes, maps."""

from omnivat.study.shift.reading import Features, read_features
from omnivat.study.shift.report import write_report

__all__ = ["Features", "read_features", "write_report"]
