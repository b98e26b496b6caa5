"""Make fractional.npz: transforms of one vector for each length, in 80-bit arithmetic.

Run from the repository's root: python -m tests.golden.make_fractional
"""

from __future__ import annotations

from pathlib import Path

import mpmath
import numpy as np

from benchmarks._reference import reference, reference_parts

SIZES = (63, 64, 65, 511, 512, 513, 768, 1024, 2048, 4096)
ORDERS = (0.3, 1.0, 1.7, -0.5, 1000.3, 1e6 + 0.37)


def vector(size: int) -> np.ndarray:
    """Fixed samples in (-1, 1), exact in float64: a linear congruential sequence."""
    state, samples = 12345, []
    for _ in range(size):
        state = (1103515245 * state + 12345) % 2**31
        samples.append(state / 2**30 - 1.0)
    return np.array(samples)


def transform_by_mpmath(x: np.ndarray, order: float) -> list:
    """F_p x from the dense matrix S in parity coordinates, with 40 digits. Slow: small N only."""
    size = len(x)
    with mpmath.workdps(40):
        s = mpmath.zeros(size)
        for n in range(size):
            s[n, n] += 2 * mpmath.cos(2 * mpmath.pi * n / size)
            s[n, (n + 1) % size] += 1
            s[n, (n - 1) % size] += 1
        result = [mpmath.mpc(0)] * size
        for parity in (1, -1):
            columns = []
            for n in range(size // 2 + 1):
                mirror = (-n) % size
                column = mpmath.zeros(size, 1)
                column[n] += 1
                column[mirror] += parity
                length = mpmath.norm(column)
                if length > 0:
                    columns.append(column / length)
            if not columns:
                continue
            p = mpmath.zeros(size, len(columns))
            for c, column in enumerate(columns):
                p[:, c] = column
            values, vectors = mpmath.eigsy(p.T * s * p)
            falling = sorted(range(len(columns)), key=lambda i: -values[i])
            for place, i in enumerate(falling):
                k = 2 * place + (parity < 0)
                v = p * vectors[:, i]
                weight = sum(v[n] * mpmath.mpf(float(x[n])) for n in range(size))
                phase = mpmath.expjpi(-mpmath.mpf(order) * k / 2)
                result = [y + phase * weight * v[n] for n, y in enumerate(result)]
        return result


def check_reference() -> float:
    """The largest error of the 80-bit reference against mpmath for small lengths."""
    worst = 0.0
    for size in range(1, 17):
        x = vector(size)
        for order in ORDERS:
            real, imaginary = reference_parts(x, order)
            exact = transform_by_mpmath(x, order)
            for n in range(size):
                for found, wanted in ((real[n], exact[n].real), (imaginary[n], exact[n].imag)):
                    high = float(found)
                    low = float(found - np.longdouble(high))
                    with mpmath.workdps(40):
                        worst = max(worst, float(abs(mpmath.mpf(high) + low - wanted)))
    return worst


def main() -> None:
    """Check the reference, then write the arrays."""
    print(f"80-bit reference against mpmath, N = 1 … 16: {check_reference():.1e}")
    arrays = {str(n): np.stack([reference(vector(n), p) for p in ORDERS]) for n in SIZES}
    np.savez_compressed(Path(__file__).with_name("fractional.npz"), **arrays)


if __name__ == "__main__":
    main()
