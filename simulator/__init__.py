"""Simulated pairs: a renderer photographs a surface, and a sensor model presses it.

Imports `omnivat`, which never imports it. A new sensor is a row in `sensors` and a domain that
names it in `domains`, a new look of a material a recipe in `surfaces/`.
"""
