"""Touch that is a signal: does a fraction of the Fourier transform help on vibrations?

    python -m benchmarks.studies.order_touch FOLDER [--table]   # a copy of dexrob/BioTac_slide_20_50
    python -m benchmarks.studies.order_touch --simulate         # a finger that accelerates

Features of windows of 256 samples: log |F_p| at five to nine orders, the order that a search finds on
the training part, the short-time Fourier transform (windows of 64, half overlapping), and the samples
themselves, each averaged over the windows of a recording; the classifier is linear discriminant analysis with shrinkage. A small network in one
dimension learns from the samples. Folds keep recordings together. In the simulation a finger of speed
v + a t slides over a grating of period λ, the class: cos(2π x / λ + φ) and its second harmonic, φ
random, behind a skin of 400 Hz, in white noise. Its chirp rate is a / λ. Nothing simulated is measured.
"""

import argparse
import json
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis
from sklearn.model_selection import KFold, StratifiedKFold
from torch import nn

from omnivat.data.readers.signals import read_signals
from omnivat.fractional import coefficients, synthesise

WINDOW, RATE = 256, 2200.0
ORDERS = (0.0, 0.25, 0.5, 0.75, 0.8, 0.85, 0.9, 0.95, 1.0)
SEARCHED = (*np.linspace(0, 0.8, 9).tolist(), *np.linspace(0.85, 1, 31).tolist())
PERIODS = (0.8, 0.9, 1.0, 1.1, 1.2)  # mm
OUT = Path("docs/benchmarks/order_touch.json")
Array = NDArray[np.float64]


def fractional(signals: Array, order: float) -> Array:
    """Return log |F_p| (N, D) of signals (N, D)."""
    parts = synthesise(coefficients(torch.from_numpy(signals)), order)
    found: Array = np.log(parts.abs().numpy() + 1e-3)
    return found


def short_time(signals: Array) -> Array:
    """Return the log magnitudes (N, frames x frequencies) of the short-time Fourier transform."""
    parts = torch.stft(torch.from_numpy(signals), 64, 32, window=torch.hann_window(64), return_complex=True)
    found: Array = np.log(parts.abs().flatten(1).numpy() + 1e-3)
    return found


def discriminant(fit: Array, labels: NDArray[Any], rest: Array) -> NDArray[Any]:
    """Return the classes of `rest` by linear discriminant analysis with shrinkage."""
    model = LinearDiscriminantAnalysis(solver="lsqr", shrinkage=0.1)
    found: NDArray[Any] = model.fit(fit, labels).predict(rest)
    return found


def searched(features: Sequence[Array], labels: NDArray[Any]) -> int:
    """Return the index of the features with the fewest errors on one inner fold."""
    fit, rest = next(iter(KFold(3, shuffle=True, random_state=0).split(labels)))
    rates = [(discriminant(f[fit], labels[fit], f[rest]) == labels[rest]).mean() for f in features]
    return int(np.argmax(rates))


def network(fit: Array, labels: NDArray[Any], rest: Array, steps: int = 400) -> Array:
    """Return logits (N, K) of `rest` by a small network: two convolutions, means over time, a map."""
    torch.manual_seed(0)
    count = int(labels.max()) + 1
    model = nn.Sequential(
        *(nn.Conv1d(1, 16, 17, stride=2), nn.ReLU(), nn.Conv1d(16, 32, 9, stride=2), nn.ReLU()),
        *(nn.AdaptiveAvgPool1d(4), nn.Flatten(), nn.Linear(128, count)),
    )
    optimiser = torch.optim.Adam(model.parameters(), lr=3e-3)
    rows, truth = torch.from_numpy(fit).float()[:, None], torch.from_numpy(labels)
    for _ in range(steps):
        batch = torch.randint(len(rows), (64,))
        optimiser.zero_grad()
        nn.functional.cross_entropy(model(rows[batch]), truth[batch]).backward()
        optimiser.step()
    with torch.inference_mode():
        found: Array = model(torch.from_numpy(rest).float()[:, None]).double().numpy()
    return found


def pooled(rows: Array, groups: NDArray[Any]) -> Array:
    """Return the mean (G, D) of the rows (N, D) of each recording."""
    found: Array = np.stack([rows[groups == g].mean(0) for g in range(groups.max() + 1)])
    return found


def compared(signals: Array, labels: NDArray[Any], groups: NDArray[Any], folds: int) -> dict[str, Any]:
    """Return the accuracy (%) of every feature on recordings, mean over folds.

    signals (N, D) and labels (N,) are windows; groups (N,) numbers their recordings. Features and
    the network's logits are averaged over the windows of a recording.
    """
    label = pooled(labels[:, None].astype(float), groups)[:, 0].astype(np.int64)
    scan = [pooled(fractional(signals, p), groups) for p in SEARCHED]
    features = {f"p = {p:g}": pooled(fractional(signals, p), groups) for p in ORDERS}
    features |= {"STFT": pooled(short_time(signals), groups), "samples": pooled(signals, groups)}
    right: dict[str, list[float]] = {name: [] for name in (*features, "search", "network")}
    orders = []
    for fit, rest in StratifiedKFold(folds, shuffle=True, random_state=0).split(label, label):
        best = searched([f[fit] for f in scan], label[fit])
        orders.append(SEARCHED[best])
        chosen = {**features, "search": scan[best]}
        made = {n: discriminant(f[fit], label[fit], f[rest]) for n, f in chosen.items()}
        ours, theirs = np.isin(groups, fit), np.isin(groups, rest)
        logits = network(signals[ours], labels[ours], signals[theirs])
        numbers = np.unique(groups[theirs], return_inverse=True)[1]
        made["network"] = pooled(logits, numbers).argmax(1)
        for name, predicted in made.items():
            right[name].append(100 * float((predicted == label[rest]).mean()))
    return {"accuracy": {n: float(np.mean(v)) for n, v in right.items()}, "orders": orders}


def finger(
    acceleration: float, noise: float, jitter: float, seed: int, count: int = 60
) -> tuple[Array, NDArray[np.int64]]:
    """Return windows (N, 256) and classes of a finger that slides over five gratings.

    acceleration  mm/s², the same for all up to `jitter`
    noise         standard deviation of white noise, in units of the fundamental
    jitter        relative standard deviation of acceleration and of the speed, 80 mm/s, at the start
    """
    random = np.random.default_rng([5, seed])
    label = np.tile(np.arange(len(PERIODS)), count)
    rates = 1 + jitter * random.standard_normal((2, len(label), 1))
    time = np.arange(WINDOW) / RATE
    speed = 80 * rates[0] + acceleration * rates[1] * time
    path = 80 * rates[0] * time + acceleration * rates[1] * time**2 / 2
    period = np.array(PERIODS)[label][:, None]
    made = noise * random.standard_normal(path.shape)
    for harmonic, size in ((1, 1.0), (2, 0.5)):
        skin = 1 / np.sqrt(1 + (harmonic * speed / period / 400) ** 2)
        phase = 2 * np.pi * (harmonic * path / period + random.random((len(label), 1)))
        made = made + size * skin * np.cos(phase)
    made -= made.mean(1, keepdims=True)
    return made / np.abs(made).max(1, keepdims=True), label


def simulated() -> list[dict[str, Any]]:
    """Compare all features over acceleration, noise and jitter."""
    steady = product((0.0, 400.0, 1600.0), (1.0,), (0.02,))
    rows = []
    for a, noise, jitter in (*steady, (1600.0, 1.0, 0.2)):
        signals, labels = finger(a, noise, jitter, seed=0)
        found = compared(signals, labels, np.arange(len(labels)), folds=2)
        rows.append({"acceleration": a, "noise": noise, "jitter": jitter, **found})
        print(rows[-1], flush=True)
    return rows


def measured(folder: Path) -> list[dict[str, Any]]:
    """Compare all features on recordings, all windows, five folds; windows share one scale."""
    found = read_signals(folder).recordings
    cuts = [one.signal[: len(one.signal) // WINDOW * WINDOW].reshape(-1, WINDOW) for one in found]
    groups = np.repeat(np.arange(len(cuts)), [len(cut) for cut in cuts])
    names = np.unique([one.material for one in found], return_inverse=True)[1]
    windows = np.concatenate(cuts).astype(np.float64)
    windows -= windows.mean(1, keepdims=True)
    results = compared(windows / windows.std(), names[groups], groups, folds=5)
    return [{"recordings": len(found), **results}]


def table(rows: Sequence[dict[str, Any]]) -> str:
    """Return a row for each setting, in Markdown."""
    names = list(rows[0]["accuracy"])
    keys = [key for key in rows[0] if key not in ("accuracy", "orders")]
    lines = [f"| {' | '.join((*keys, *names))} | orders found |"]
    lines.append("| " + " | ".join(["---"] * (len(keys) + len(names) + 1)) + " |")
    for row in rows:
        cells = [f"{row[key]:g}" for key in keys]
        cells += [f"{row['accuracy'][name]:.1f}" for name in names]
        orders = ", ".join(f"{p:.2f}" for p in row["orders"])
        lines.append(f"| {' | '.join(cells)} | {orders} |")
    return "\n".join(lines)


def main() -> None:
    """Measure, or print the tables of the record."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--simulate", action="store_true")
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    torch.set_num_threads(1)
    there = json.loads(options.out.read_text("utf-8")) if options.out.is_file() else {}
    if options.simulate:
        there["simulated"] = simulated()
    if options.folder:
        there["measured"] = measured(options.folder)
    if options.simulate or options.folder:
        options.out.write_text(json.dumps(there, indent=1) + "\n", encoding="utf-8")
    for name, rows in there.items():
        print(f"\n{name}\n\n{table(rows)}")


if __name__ == "__main__":
    main()
