"""The trained head: MFFA, FrATT and DTG over frozen embeddings, and what belongs to its file.

Imports `encoders`, `data`, `fractional` and `kit`. Read `reference` first: it is the paper, top to
bottom. A new fusion is a function in `fusion` and a line in its table.
"""
