"""What the page draws: maps of a set at every order, curves, thumbnails, and the nodes of DTG's
tree.

Imports `measure`, `head`, `data` and `kit`. A new projection is a module in `projection/` and a
line in its table.
"""
