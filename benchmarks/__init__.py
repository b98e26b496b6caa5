"""Benchmarks of speed and accuracy; each module writes a page or table of docs/."""
