"""The discrete fractional Fourier transform: exact eigenbasis, cached coefficients, any order."""

from omnivat.fractional.coefficients import Coefficients
from omnivat.fractional.transform import coefficients, dfrft, synthesise

__all__ = ["Coefficients", "coefficients", "dfrft", "synthesise"]
