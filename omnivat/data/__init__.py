"""Pairs of images, the names they carry, and the file their embeddings live in."""
