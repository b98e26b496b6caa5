"""What the page draws: maps of a set at every order, curves, the epochs of a training, thumbnails,
and the nodes of DTG's tree.

Imports `measure`, `training`, `head`, `data` and `kit`. A new projection is a module in
`projection/` and a line in its table.
"""
