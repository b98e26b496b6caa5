"""Pairs of images, their names, and the file of their embeddings."""
