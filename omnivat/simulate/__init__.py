"""Simulated pairs: a renderer photographs a surface, and a sensor model presses it."""
