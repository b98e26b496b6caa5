"""The trained head: MFFA, FrATT and DTG over frozen embeddings."""
