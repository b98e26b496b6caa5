"""The transform along an axis with a meaning: rows of pictures and rows of an encoder's map.

    python -m benchmarks.studies.order_axis [--shuffles 3] [--out docs/benchmarks/order_axis.json] [--table]

A signal is one row of a picture (64 samples), or one row of one channel of EfficientNet-Lite0's
last map of 14 × 14 patches. The feature is the mean of |F_p| over the rows, for every channel: at
p = 0 where along the row something is, at p = 1 the spectrum, which is a descriptor of texture. A
logistic probe learns from it in one domain and predicts in the seven others. Shuffled: the samples
of each row in another order, the same for every picture. Pictures are the set's thumbnails, 56
pixels a side.
"""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from PIL import Image
from torch import Tensor

from benchmarks.measure import machine
from benchmarks.simulated_probe import fitted
from benchmarks.studies._order_sets import pictures
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.encoders.efficientnet import EfficientNetLite0, load_lite0
from omnivat.fractional import dfrft
from omnivat.head.heads import default_embeddings
from omnivat.measure.unseen import counted, mean_over_domains
from omnivat.study.reports.intervals import t_interval

STOPS = (0.0, 0.25, 0.5, 0.75, 1.0)
SIDE = 64  # samples of a row of a picture
PATCHES = 14  # a side of the encoder's map
BATCH = 32
KINDS = ("rows of tactile images", "rows of photos", "patches of tactile images", "patches of photos")
Row = dict[str, Any]


def grey_rows(tiles: list[Image.Image]) -> Tensor:
    """Return the rows of pictures: (N, 1, SIDE, SIDE), the last axis along the row."""
    size = (SIDE, SIDE)
    grey = [np.asarray(tile.convert("L").resize(size), dtype=np.float32) for tile in tiles]
    return torch.from_numpy(np.stack(grey))[:, None]


@torch.inference_mode()
def patches(tiles: list[Image.Image], encoder: EfficientNetLite0) -> Tensor:
    """Return the encoder's last map of 14 × 14 patches: (N, C, 14, 14)."""
    network: Any = encoder._network
    found: list[Tensor] = []
    for start in range(0, len(tiles), BATCH):
        some = torch.stack([encoder.preprocess(tile) for tile in tiles[start : start + BATCH]])
        x = torch.relu(network.stem(some)).clamp_max_(6)
        for block in network.blocks:
            after = block(x)
            if after.shape[-1] < PATCHES:
                break
            x = after
        found.append(x)
    return torch.cat(found)


def spectra(signals: Tensor, order: float, shuffle: int | None) -> NDArray[np.float32]:
    """Return the features (N, C W): mean of |F_p| over the rows (N, C, H, W) of each channel.

    Each row is centred first. shuffle: the seed of another order of the samples; None: their own.
    """
    rows = signals - signals.mean(-1, keepdim=True)
    if shuffle is not None:
        rows = rows[..., np.random.default_rng(shuffle).permutation(rows.shape[-1])]
    found = [dfrft(some, order).abs().mean(2).flatten(1) for some in rows.split(BATCH)]
    return torch.cat(found).numpy().astype(np.float32)


def scored(values: NDArray[np.float32], embeddings: Embeddings, source: str) -> float:
    """Return the probe's accuracy (%) in unseen domains, from (N, F) features."""
    names = np.array(embeddings.header.classes)[embeddings.label]
    own = embeddings.domain == embeddings.header.domains.index(source)
    own &= np.array(embeddings.rows["split"], dtype=object) == "train"
    mean, deviation = values[own].mean(0), values[own].std(0) + 1e-6
    scaled = (values - mean) / deviation
    probe, classes = fitted(scaled[own], names[own])
    right = classes[probe(scaled).argmax(1)] == names
    return 100 * (mean_over_domains(right, embeddings, source, counted(embeddings, source)) or float("nan"))


def measured(file: Path, shuffles: int) -> Iterator[Row]:
    """Yield the accuracy of every kind, order, shuffle and source."""
    embeddings, tiles = load_embeddings(file), pictures(file)
    encoder = load_lite0(weights=None, device=torch.device("cpu"))
    count = len(embeddings)
    for kind in KINDS:
        some = tiles[count:] if "tactile" in kind else tiles[:count]
        signals = grey_rows(some) if kind.startswith("rows") else patches(some, encoder)
        for shuffle in (None, *range(shuffles)):
            for order in STOPS:
                values = spectra(signals, order, shuffle)
                for source in embeddings.header.domains:
                    unseen = scored(values, embeddings, source)
                    key = {"kind": kind, "shuffle": shuffle, "order": order, "source": source}
                    yield {**key, "unseen": unseen}


def table(rows: list[Row]) -> str:
    """Return the mean over sources of each kind and order, in order and shuffled, in Markdown."""
    lines = [
        "| signal | samples | " + " | ".join(f"p = {p:g}" for p in STOPS) + " | p = 1 less p = 0 |",
        "| --- | --- |" + " --- |" * (len(STOPS) + 1),
    ]
    for kind in KINDS:
        for name, shuffled in (("in order", False), ("shuffled", True)):
            found = [_by_source(rows, kind, order, shuffled) for order in STOPS]
            cells = " | ".join(f"{np.mean(values):.1f}" for values in found)
            lines.append(f"| {kind} | {name} | {cells} | {_interval(found[-1] - found[0])} |")
        gained = [
            _by_source(rows, kind, 1.0, shuffled) - _by_source(rows, kind, 0.0, shuffled) for shuffled in (False, True)
        ]
        lines.append(f"| | in order less shuffled | | | | | | {_interval(gained[0] - gained[1])} |")
    return "\n".join(lines)


def _by_source(rows: list[Row], kind: str, order: float, shuffled: bool) -> NDArray[np.float64]:
    """Return the accuracy (S,) of each source; the mean over shuffles."""
    own = [row for row in rows if (row["kind"], row["order"], row["shuffle"] is not None) == (kind, order, shuffled)]
    return np.array(
        [
            np.mean([row["unseen"] for row in own if row["source"] == source])
            for source in dict.fromkeys(row["source"] for row in own)
        ]
    )


def _interval(differences: NDArray[np.float64]) -> str:
    """Return the mean of differences (S,) of sources and Student's 95 % interval."""
    found = t_interval(differences.tolist())
    return f"{found.mean:+.1f} [{found.low:.1f}, {found.high:.1f}]"


def main() -> None:
    """Measure, or print the record as a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--embeddings", type=Path, default=default_embeddings())
    parser.add_argument("--shuffles", type=int, default=3)
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks/order_axis.json"))
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    if options.table:
        return print(table(json.loads(options.out.read_text(encoding="utf-8"))["rows"]))
    rows = list(measured(options.embeddings, options.shuffles))
    record = {"study": "axis", "machine": machine(), "rows": rows}
    options.out.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    return print(table(rows))


if __name__ == "__main__":
    main()
