"""Multiply by V and Vᵀ: one class for each way to split V into blocks.

V is orthogonal and real. Every split has the same two maps on rows: `analyse(x, out)` sets
out = x V on (R, N); `restore(z, out)` sets out = z Vᵀ on (..., N) and overwrites z, which is
contiguous and may be out itself. `indices` gives k of every column of V; their order differs
between splits.

The quarter split (N = 4M) has four blocks of N/4 and two butterflies, a quarter of the work of V.
One butterfly combines samples j, N/2-j, N/2+j and N-j (parity and Q), the other coefficients k and
their mirror images. j = 0 and the middle j = M are their own partners and are treated separately.
The blocks of Q = -1 include the signs (-1)^j, so each butterfly is one fused multiply-add.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import torch
from jaxtyping import Float, Float64
from torch import Tensor
from torch.utils._python_dispatch import _disable_current_modes

from omnivat.fractional.double_double import Array
from omnivat.fractional.eigenvectors import QuarterFactor, alternating

_FEW_ROWS = 32
_FEW_ROWS_UP_TO = 1024  # N; for larger N, products dominate


@contextmanager
def kept_numbers() -> Iterator[None]:
    """Compute what is kept for later calls: with numbers even while a program is exported or under
    `torch.func`, and without gradients."""
    outside = torch._C._DisableFuncTorch()
    with outside, _disable_current_modes(), torch.inference_mode(False), torch.no_grad():
        yield


class HalfSplit:
    """Separate even and odd vectors: two blocks of N/2, half the work of V. For any N.

    even, odd: the first half of the samples of the eigenvectors, h = N//2 + 1 and g = (N - 1)//2 of
    them, columns by increasing k. One row gives a sample and its mirror image.
    """

    def __init__(
        self, even: Float[Tensor, "h h"], odd: Float[Tensor, "g g"], indices: Float64[Tensor, " N"]
    ) -> None:
        self.even, self.odd, self.indices = even, odd, indices

    def analyse(self, x: Float[Tensor, "R N"], out: Float[Tensor, "R N"]) -> None:
        """Write the coefficients of rows x, in the order of `indices`, to `out`."""
        size, half, paired = x.shape[-1], len(self.even), len(self.odd)
        mirrored = x[:, size - paired :].flip(-1)
        sums = x[:, :half].clone()
        sums[:, 1 : paired + 1] += mirrored
        torch.mm(sums, self.even, out=out[:, :half])
        torch.mm(x[:, 1 : paired + 1] - mirrored, self.odd, out=out[:, half:])

    def restore(self, z: Float[Tensor, "*lead N"], out: Float[Tensor, "*lead N"]) -> None:
        """Write the samples of coefficients z to `out`."""
        size, half, paired = z.shape[-1], len(self.even), len(self.odd)
        even = z[..., :half] @ self.even.T
        odd = z[..., half:] @ self.odd.T
        out[..., :half] = even
        out[..., 1 : paired + 1] += odd
        out[..., size - paired :] = (even[..., 1 : paired + 1] - odd).flip(-1)


class _Parity:
    """The two blocks of one parity: positions of their coefficients, and their weights.

    Coefficients of a parity are ordered [σ > 0, decreasing | null vector | their mirror images].
    """

    def __init__(self, factor: QuarterFactor, start: int, first: int, like: Tensor) -> None:
        pairs = len(factor.small)
        self.null = start + pairs
        end = self.null + 1 + pairs
        self.low, self.high = slice(start, self.null), slice(self.null + 1, end)
        self.indices = 2.0 * np.r_[: pairs + 1, 2 * pairs : pairs : -1] + first
        self.first = first  # of its samples in [0, M); the large side also has the middle one
        self.large = pairs % 2  # the side with the middle sample: 0 for Q = +1, 1 for Q = -1
        # In restore the large side also uses the null vector, which lies next to both halves.
        cut = self.null + 1 - self.large
        self.sides = slice(start, cut), slice(cut, end)
        scale = np.full((pairs + 1, 1), 2.0**-1.5)
        if first == 0:
            scale[0] = 0.5  # sample 0 has no mirror image
        scale[-1] = 0.5
        wide = factor.large * scale
        wide[:, -1] *= np.sqrt(2.0)  # the null vector has no mirror image
        narrow = factor.small * scale[:-1]
        minus = wide[:-1] if self.large else narrow
        minus *= -alternating(pairs + first)[first:, None]

        def tensor(block: Array) -> Tensor:
            return torch.from_numpy(np.ascontiguousarray(block)).to(like)

        def padded(block: Array, before: int, after: int) -> Tensor:
            # zeros, to M samples or M coefficients, because odd widths are slower
            return tensor(np.pad(block, ((0, 0), (before, after))))

        self.to_null = tensor(wide[:, -1])  # one coefficient from all samples of the large side
        # plus, then minus: (samples, coefficients), and (coefficients, samples)
        sides = slice(None, None, 1 - 2 * self.large)
        self.analysing = [padded(w, 0, first) for w in (wide[:, :-1], narrow)][sides]
        wide = np.roll(wide, self.large, axis=1)
        self.middle = tensor(wide[-1])  # one sample from all coefficients of the large side
        self.restoring = [padded(w, first, 0) for w in (wide[:-1].T, narrow.T)][sides]


class QuarterSplit:
    """Four blocks of N/4 for N divisible by 4, N ≥ 8."""

    def __init__(self, even: QuarterFactor, odd: QuarterFactor, like: Tensor) -> None:
        self.quarter = len(even.small)
        m = self.quarter
        self.parities = (_Parity(even, 0, 0, like), _Parity(odd, 2 * m + 1, 1, like))
        self.signs = torch.from_numpy(alternating(m)).to(like)
        self.flipped = self.signs.flip(-1)
        indices = np.concatenate([parity.indices for parity in self.parities])
        self.indices = torch.from_numpy(indices).to(like.device)
        self._halves: HalfSplit | None = None

    def _for_few_rows(self, rows: int) -> HalfSplit | None:
        """Return the half split, faster where calls dominate: 9 operations instead of 30."""
        if rows > _FEW_ROWS or self.quarter > _FEW_ROWS_UP_TO // 4:
            return None
        if self._halves is None:
            with kept_numbers():
                half = 2 * self.quarter
                samples = self.signs.new_empty(2 * half, 2 * half)
                self._restore(torch.eye(2 * half).to(samples), samples)
                even, odd = samples[: half + 1, : half + 1].T, samples[half + 1 :, 1:half].T
                self._halves = HalfSplit(even.contiguous(), odd.contiguous(), self.indices)
        return self._halves

    def analyse(self, x: Float[Tensor, "R N"], out: Float[Tensor, "R N"]) -> None:
        """Write the coefficients of rows x, in the order of `indices`, to `out`."""
        halves = self._for_few_rows(len(x))
        (self._analyse if halves is None else halves.analyse)(x, out)

    def restore(self, z: Float[Tensor, "*lead N"], out: Float[Tensor, "*lead N"]) -> None:
        """Write the samples of coefficients z to `out`."""
        halves = self._for_few_rows(z.numel() // z.shape[-1])
        (self._restore if halves is None else halves.restore)(z, out)

    def _analyse(self, x: Tensor, out: Tensor) -> None:
        m, rows = self.quarter, len(x)
        signs, flipped = self.signs, self.flipped[: m - 1]
        near, far = x[:, :m], x[:, 2 * m : 3 * m]
        near_mirrored, far_mirrored = x[:, 3 * m + 1 :], x[:, m + 1 : 2 * m]
        # samples by side: plus and minus of even and odd; the last column is j = M
        even, odd = sides = x.new_empty(2, 2, rows, m + 1)
        torch.addcmul(near, far, signs, out=even[0, :, :m])
        torch.addcmul(far, near, signs, value=-1, out=even[1, :, :m])
        mirrored = x.new_empty(2, rows, m - 1)
        torch.addcmul(near_mirrored, far_mirrored, flipped, out=mirrored[0])
        torch.addcmul(far_mirrored, near_mirrored, flipped, value=-1, out=mirrored[1])
        mirrored = mirrored.flip(-1)
        torch.sub(even[:, :, 1:m], mirrored, out=odd[:, :, 1:m])
        even[:, :, 1:m] += mirrored
        product = x.new_empty(2, rows, m)
        for parity, samples in zip(self.parities, sides, strict=True):
            samples = samples[:, :, parity.first :]
            large = samples[parity.large]
            torch.add(x[:, m], x[:, 3 * m], alpha=1 - 2 * parity.first, out=large[:, -1])
            for side, weights in enumerate(parity.analysing):
                torch.mm(samples[side, :, : len(weights)], weights, out=product[side])
            plus, minus = product[:, :, : m - parity.first]
            torch.add(plus, minus, out=out[:, parity.low])
            torch.sub(plus, minus, out=out[:, parity.high])
            out[:, parity.null] = large @ parity.to_null

    def _restore(self, z: Tensor, out: Tensor) -> None:
        m = self.quarter
        leading = out.shape[:-1]
        z = z.flatten(0, -2)
        sides = z.new_empty(2, 2, len(z), m)
        middles = []
        for parity, samples in zip(self.parities, sides, strict=True):
            low, high = z[:, parity.low], z[:, parity.high]
            low += high
            torch.add(low, high, alpha=-2, out=high)  # now low + high and low - high, in place
            for side, weights in enumerate(parity.restoring):
                torch.mm(z[:, parity.sides[side]], weights, out=samples[side])
            middles.append((z[:, parity.sides[parity.large]] @ parity.middle).view(leading))
        even, odd = sides.view(2, 2, *leading, m)
        mirrored = torch.sub(even, odd).flip(-1)
        even += odd
        plus, minus = even
        torch.addcmul(plus, minus, self.signs, value=-1, out=out[..., :m])
        torch.addcmul(minus, plus, self.signs, out=out[..., 2 * m : 3 * m])
        plus, minus = mirrored[..., : m - 1]
        signs = self.flipped[: m - 1]
        torch.addcmul(plus, minus, signs, value=-1, out=out[..., 3 * m + 1 :])
        torch.addcmul(minus, plus, signs, out=out[..., m + 1 : 2 * m])
        torch.add(middles[0], middles[1], out=out[..., m])
        torch.sub(middles[0], middles[1], out=out[..., 3 * m])


Split = HalfSplit | QuarterSplit  # V in blocks, on one device and in one precision
