"""Simulated pairs: a renderer photographs a surface, and a sensor model presses it.

Imports `data`, `fractional` and `kit`. A new sensor is a row in `sensors`, a new domain a row in
`domains`, a new look of a material a recipe in `surfaces/`.
"""
