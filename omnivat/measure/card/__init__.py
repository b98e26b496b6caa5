"""The card of a sensor: what its touches show of it, and what changed between two folders.

Imports `data` and `encoders.hub`. `traits` reads one picture, `card` sums a folder up, `changes`
compares two, `report` puts both into words, `of_set` compares the domains of a set. A new change is
a row of `changes.MEASURES` or an arrangement in `changes.ARRANGEMENTS`.
"""
