"""Reference transforms."""

import numpy as np


def dense_transform(size, order):
    """F_p from the dense S and a parity split, in plain numpy."""
    n = np.arange(size)
    s = np.diag(2 * np.cos(2 * np.pi * n / size))
    for i in n:
        s[i, (i + 1) % size] += 1
        s[i, (i - 1) % size] += 1
    result = np.zeros((size, size), complex)
    for parity in (1, -1):
        columns = []
        for i in range(size // 2 + 1):
            column = np.zeros(size)
            column[i] += 1
            column[-i % size] += parity
            if np.linalg.norm(column) > 0:
                columns.append(column / np.linalg.norm(column))
        if not columns:
            continue
        p = np.array(columns).T
        vectors = p @ np.linalg.eigh(p.T @ s @ p)[1][:, ::-1]
        k = 2 * np.arange(len(columns)) + (parity < 0)
        result += (vectors * np.exp(-0.5j * np.pi * order * k)) @ vectors.T
    return result


def dft(size):
    """The unitary DFT."""
    return np.fft.fft(np.eye(size), norm="ortho")
