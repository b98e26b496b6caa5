"""Pairs of images: reading them, their domains, classes and splits, and the file of their
embeddings.

Imports `kit` alone. A new layout is a module in `readers/` and a line in its table;
a new paper data set is a line in `paper_sets`; a set to fetch is a row of `fetching/sets.json` and
a layout in `fetching/layouts.py`.
"""
