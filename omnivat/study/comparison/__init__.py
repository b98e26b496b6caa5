"""Several embeddings of the same pairs in one table: which encoder survives a new sensor."""

from omnivat.study.comparison.compare import compare, predicted_numbers, sentence
from omnivat.study.comparison.table import table

__all__ = ["compare", "predicted_numbers", "sentence", "table"]
