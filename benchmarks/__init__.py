"""Measured speed and accuracy; each module writes what docs/ show."""
