"""Reference transforms: exact ones, and wrong ones that tests must reject."""

import numpy as np


def dense_transform(size: int, order: float) -> np.ndarray:
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


def dft(size: int) -> np.ndarray:
    """The unitary DFT."""
    return np.fft.fft(np.eye(size), norm="ortho")


def principal_branch(size: int, order: float) -> np.ndarray:
    """Wrong: powers of the DFT's eigenvalues, -π < angle ≤ π, by projections on its eigenspaces."""
    f = dft(size)
    powers = [np.linalg.matrix_power(f, j) for j in range(4)]
    result = np.zeros((size, size), complex)
    for angle in (0, -1, 2, 1):  # eigenvalue i**angle
        projection = sum((1j**angle) ** (-j) * powers[j] for j in range(4)) / 4
        result += np.exp(0.5j * np.pi * order * angle) * projection
    return result


def _with_indices(size: int, order: float, k: np.ndarray) -> np.ndarray:
    from omnivat.fractional import basis

    vectors = basis(size).vectors.numpy()
    return (vectors * np.exp(-0.5j * np.pi * order * k)) @ vectors.T


def index_modulo_four(size: int, order: float) -> np.ndarray:
    """Wrong: unitary, additive, period 4 and F_1 = DFT, yet not the transform."""
    from omnivat.fractional import basis

    return _with_indices(size, order, basis(size).indices.numpy() % 4)


def no_skip(size: int, order: float) -> np.ndarray:
    """Wrong for even N: the last k is N - 1."""
    return _with_indices(size, order, np.arange(size))


def no_parity_split(size: int, order: float) -> np.ndarray:
    """Wrong for N % 4 = 0: eigenvectors of the dense S, whose double zero mixes parities."""
    n = np.arange(size)
    s = np.diag(2 * np.cos(2 * np.pi * n / size))
    for i in n:
        s[i, (i + 1) % size] += 1
        s[i, (i - 1) % size] += 1
    vectors = np.linalg.eigh(s)[1][:, ::-1]
    k = np.append(np.arange(size - 1), size if size % 2 == 0 else size - 1)
    return (vectors * np.exp(-0.5j * np.pi * order * k)) @ vectors.T


FAKES = (principal_branch, index_modulo_four, no_skip, no_parity_split)
