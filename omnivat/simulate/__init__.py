"""Simulated pairs: one surface, photographed by a renderer and pressed by a sensor model."""
