"""Does a smaller gap predict a better head? Rank correlations over everything that is recorded.

    python -m benchmarks.gap_predicts [--out docs/benchmarks]

Between heads: 21 heads of each shipped set, each trained at one p (`trained.bin`). Within a head: p moved
under fixed weights (`frames.bin`, `every.bin`); and over the unseen domains at one p. Between methods:
every run of the protocol, by source. Nothing is trained here.
"""

import argparse
import json
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata, spearmanr

from omnivat.figures.drawing import GRID, INK, Picture, Shape, write_picture
from omnivat.figures.drawing import text as words
from omnivat.files import write_text
from omnivat.frames.file import frames_header
from omnivat.protocol.records import read
from omnivat.reports.reading import settled

EXAMPLES = Path("examples")
SETS = {"sensors": EXAMPLES, "chirps": EXAMPLES / "chirps"}
FILES = {
    "trained.bin": "between heads, one trained at each p",
    "every.bin": "within a head for every p",
    "frames.bin": "within a head, p moved",
}
MEASURES = {
    "modality_gap": "modality gap",
    "domain_gap": "domain gap",
    "margin": "class margin",
    "margin:cross_modal": "class margin, photo to touch",
}
STAGES, DRAWS = ("relu", "f_bar", "f_hat"), 2000
Array = NDArray[np.float64]
Found = tuple[float, float, float]


def agreement(x: Array, y: Array) -> Array:
    """Return Pearson's correlation along the last axis; 0 if one side is constant."""
    x, y = x - x.mean(-1, keepdims=True), y - y.mean(-1, keepdims=True)
    both = np.sqrt((x * x).sum(-1) * (y * y).sum(-1))
    found: Array = np.where(both > 1e-12, (x * y).sum(-1) / np.maximum(both, 1e-12), 0.0)
    return found


def interval(units: int, of: Callable[[NDArray[np.int64]], Array]) -> Found:
    """Return a statistic and its 95 % percentile interval over redrawn units.

    of  rows (B, units) -> (B,)
    """
    drawn = of(np.random.default_rng(0).integers(units, size=(DRAWS, units)))
    low, high = np.quantile(drawn, [0.025, 0.975])
    return float(of(np.arange(units)[None])[0]), float(low), float(high)


def along_stops(curves: Mapping[str, Any]) -> dict[str, dict[str, Found]]:
    """Return stage -> measure -> correlation with accuracy in unseen domains, over stops."""
    right = rankdata(curves["accuracy/unseen"])

    def one(name: str) -> Found:
        ranks = rankdata(curves[name])
        return interval(len(right), lambda rows: agreement(ranks[rows], right[rows]))

    return {stage: {name: one(f"{name}/{stage}") for name in MEASURES} for stage in STAGES}


def over_domains(header: Mapping[str, Any], source: str) -> Found:
    """Return the mean over heads of the correlation, over unseen domains, of gap and accuracy."""
    curves = header["curves"]
    names = [d for d in header["domains"] if d != source]
    gaps = rankdata([curves[f"modality_gap/f_hat/{d}"] for d in names], axis=0).T
    right = rankdata([curves[f"accuracy/{d}"] for d in names], axis=0).T
    return interval(len(names), lambda rows: agreement(gaps[:, rows], right[:, rows]).mean(0))


def between_methods() -> dict[str, Found]:
    """Return margin -> mean over sources of its correlation with accuracy, over methods."""
    cells: dict[str, dict[str, list[tuple[float, float]]]] = defaultdict(lambda: defaultdict(list))
    pooled: dict[tuple[str, str, str], list[tuple[float, float]]] = defaultdict(list)
    for record in map(settled, read(EXAMPLES / "records" / "protocol_full.jsonl.gz")):
        for target in record.get("targets", {}).values():
            for kind, margin in target["margins"].items():
                reading = "fused" if kind == "pair" else kind
                if margin is not None:
                    key = (kind, record["source"], record["method"])
                    pooled[key].append((margin, target["scores"][reading]["accuracy"]))
    for (kind, source, _), pairs in pooled.items():
        cells[kind][source].append(tuple(np.mean(pairs, axis=0)))
    found = {}
    for kind, by_source in cells.items():
        values = np.array([spearmanr(*np.array(p).T).statistic for p in by_source.values()])
        found[kind] = interval(len(values), partial(_mean, values))
    return found


def _mean(values: Array, rows: NDArray[np.int64]) -> Array:
    found: Array = values[rows].mean(-1)
    return found


def text(found: Found) -> str:
    """Return "+0.13 [-0.30, 0.52]"."""
    return f"{found[0]:+.2f} [{found[1]:.2f}, {found[2]:.2f}]"


def report(found: Mapping[str, Any]) -> str:
    """Return the tables as Markdown."""
    parts = ["# Does a smaller gap predict a better head?", __doc__.split("\n\n")[2]]
    parts.append(
        "Spearman's rank correlation with accuracy in unseen domains; brackets hold 95 % percentile "
        "intervals over redrawn stops, domains or sources (ranked once). If small gaps made good heads, the gaps' "
        "figures would be near −1. Stops of one head are not independent, so its intervals are too narrow."
    )
    for name, kinds in found["stops"].items():
        parts.append(f"## {name.capitalize()}")
        rows = [f"| what varies | stage | {' | '.join(MEASURES.values())} |", "| --- " * 6 + "|"]
        for kind, stages in kinds.items():
            for stage, cells in stages.items():
                rows.append(f"| {kind} | {stage} | {' | '.join(map(text, cells.values()))} |")
        parts.append("\n".join(rows))
    lines = [f"- {name}: {text(v)}" for name, v in found["domains"].items()]
    parts += ["## Over unseen domains, within a head: modality gap", "\n".join(lines)]
    lines = [f"- {kind}: {text(v)}" for kind, v in found["methods"].items()]
    parts += ["## Over methods of the protocol, within a source: cosine margin", "\n".join(lines)]
    return "\n\n".join([*parts, "![Gap and margin against accuracy](gap_predicts.svg)"]) + "\n"


def draw(headers: Mapping[str, Mapping[str, Any]], file: Path) -> None:
    """Draw gap and margin at F̂ against accuracy, a dot for each head."""
    shapes, (wide, high, edge) = [], (250.0, 190.0, 46.0)
    for row, (name, header) in enumerate(headers.items()):
        curves = header["curves"]
        right = 100 * np.array(curves["accuracy/unseen"])
        for column, measure in enumerate(list(MEASURES)[:3]):
            x0, y0 = edge + column * (wide + edge), 16 + row * (high + edge)
            gaps = np.array(curves[f"{measure}/f_hat"])
            corners = ((x0, y0), (x0 + wide, y0 + high))
            shapes.append(Shape(kind="rect", points=corners, stroke=GRID))
            across, up = _placed(gaps, x0, wide), 2 * y0 + high - _placed(right, y0, high)
            for point in zip(across.tolist(), up.tolist(), strict=True):
                shapes.append(Shape(kind="circle", points=(point,), size=4, fill=INK, opacity=0.6))
            for values, ends, anchor in (
                (gaps, ((x0, y0 + high + 14), (x0 + wide, y0 + high + 14)), "middle"),
                (right, ((x0 - 4, y0 + high), (x0 - 4, y0 + 10)), "end"),
            ):
                for value, place in zip((values.min(), values.max()), ends, strict=True):
                    shapes.append(words(place, f"{value:.3g}", 11, anchor))
            title = f"{MEASURES[measure]}, {name}"
            shapes.append(words((x0 + wide / 2, y0 + high + 30), title, 12, "middle"))
    title = "Unseen ACC in percent (up) against gap or margin at F̂ (across), a dot for each head"
    size = (4 * edge + 3 * wide, 2 * (high + edge) + 20)
    write_picture(file, Picture(width=size[0], height=size[1], shapes=tuple(shapes), title=title))


def _placed(values: Array, start: float, length: float) -> Array:
    found: Array = start + length * (0.05 + 0.9 * (values - values.min()) / np.ptp(values))
    return found


def measured(headers: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> dict[str, Any]:
    """Return every correlation, from set -> file -> header."""
    return {
        "stops": {
            name: {FILES[file]: along_stops(h["curves"]) for file, h in files.items()}
            for name, files in headers.items()
        },
        "domains": {
            name: over_domains(files["trained.bin"], files["trained.bin"]["head"]["source"])
            for name, files in headers.items()
        },
        "methods": between_methods(),
    }


def main(given: Sequence[str] | None = None) -> None:
    """Measure, print, and write the tables, the record and the figure."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks"))
    options = parser.parse_args(given)
    headers = {
        name: {file: frames_header(folder / file) for file in FILES}
        for name, folder in SETS.items()
    }
    found = measured(headers)
    write_text(options.out / "gap_predicts.json", json.dumps(found, indent=1) + "\n")
    write_text(options.out / "gap_predicts.md", report(found))
    draw(
        {n: files["trained.bin"] for n, files in headers.items()}, options.out / "gap_predicts.svg"
    )
    print(report(found))


if __name__ == "__main__":
    main()
