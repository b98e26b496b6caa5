"""Benchmarks of speed and accuracy; README.md lists them."""
