"""The card of a sensor: what its touches show of it, and what changed between two folders.

Imports `data`. `traits` reads one picture, `card` sums a folder up, `changes` compares two,
`report` puts both into words. A new change is a row of `changes.MEASURES` or an arrangement in
`changes.ARRANGEMENTS`.
"""
