"""Cost of each method on one source: size, seconds per epoch, peak memory, prediction rate.

    python -m benchmarks.cost [--source TAG] [--methods a,b,c] [--out docs/benchmarks]

Every method runs in a separate process on one thread, so its peak memory is separate. A fit
includes the choice of settings. An epoch is a pass over the training pairs, for methods with
epochs. Predictions are of single pairs: from embeddings, and with the default encoder, whose time
is measured once on one thread.
"""

import argparse
import json
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from benchmarks.measure import machine

METHODS = (
    "omnivat",
    "omnivat, D = 64",
    "mffa_alone",
    "dtg_alone",
    "cosine_head",
    "nearest_mean",
    "linear_probe",
    "linear_probe_concat",
    "linear_probe_sum",
    "erm_mlp",
    "baseline",
    "vt_cmc_head",
    "ldc_icd",
)
PAIRS = 200  # predicted one by one for the speed
EPOCHS = {"erm_mlp": 20, "baseline": 20, "vt_cmc_head": 40, "ldc_icd": 30}
HEAD_EPOCHS = 3


def run() -> None:
    """Measure every method in a separate process, then write JSON and a table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--source", default="TAG")
    parser.add_argument("--methods", default=";".join(METHODS))
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks"))
    parser.add_argument("--one", default="", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measured(options.one, options.source)))
        return
    rows = []
    for name in options.methods.split(";"):
        command = [sys.executable, "-m", "benchmarks.cost", "--source", options.source]
        done = subprocess.run([*command, "--one", name], capture_output=True, text=True, check=True)
        rows.append(json.loads(done.stdout.splitlines()[-1]))
        print(json.dumps(rows[-1]), flush=True)
    found = {
        "machine": machine(),
        "source": options.source,
        "encoder": {"seconds a pair": encoder_seconds()},
        "rows": rows,
    }
    (options.out / "cost.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    (options.out / "cost.md").write_text(table(found), encoding="utf-8")
    print(table(found))


def measured(name: str, source: str) -> dict[str, Any]:
    """Return the cost of one method, in CPU seconds of one thread."""
    import torch

    from omnivat.data.store import load_embeddings
    from omnivat.encoders.lang.bank import load_bank
    from omnivat.head.heads import default_embeddings
    from omnivat.study.protocol.fitting import fit
    from omnivat.study.protocol.methods import methods_named
    from omnivat.study.protocol.settings import task

    torch.set_num_threads(1)
    embeddings, bank = load_embeddings(default_embeddings()), load_bank()
    found = task(embeddings, source)
    base, width = ("omnivat", 64) if name == "omnivat, D = 64" else (name, 512)
    (method,) = methods_named([base], {"width": width}, {"epochs": HEAD_EPOCHS})
    start = peak_mb()
    began = time.process_time()
    outcome = fit(method, found, bank, seed=0, calibrate=False)
    seconds = time.process_time() - began
    epochs = HEAD_EPOCHS if method.base == "omnivat" else EPOCHS.get(base)
    pairs = found.train.select(found.train.label >= 0)
    outcome.logits(pairs)  # warm
    began = time.process_time()
    for row in range(PAIRS):
        keep = torch.zeros(len(pairs), dtype=torch.bool)
        keep[row % len(pairs)] = True
        outcome.logits(pairs.select(keep.numpy()))
    predicted = time.process_time() - began
    tuned = base in EPOCHS  # four candidates on three quarters of the pairs, then the fit
    share = 1 + 4 * 0.75 if tuned and base != "vt_cmc_head" else 1
    return {
        "method": name if name != "omnivat" else "omnivat, D = 512",
        "label": (method.label or name) + (", D = 64" if width == 64 else ""),
        "parameters": outcome.parameters,
        "fit_s": round(seconds, 2) if method.base != "omnivat" else None,
        "epoch_s": round(seconds / epochs / share, 3) if epochs else None,
        "memory_mb": round(peak_mb() - start),
        "peak_mb": round(peak_mb()),
        "pair_s": predicted / PAIRS,
        "pairs": len(found.train),
    }


def peak_mb() -> float:
    """Return the process's peak resident memory, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def encoder_seconds(count: int = 10) -> float:
    """Return CPU seconds of the default encoder for one pair: two images, on one thread."""
    import torch

    from omnivat.encoders import load_encoder

    torch.set_num_threads(1)
    encoder = load_encoder("efficientnet-lite0")
    pixels = torch.rand(1, 3, 224, 224)
    encoder.embed(pixels)
    began = time.process_time()
    for _ in range(2 * count):
        encoder.embed(pixels)
    return (time.process_time() - began) / count


def table(found: dict[str, Any]) -> str:
    """Return the Markdown page."""
    encoder, facts = found["encoder"]["seconds a pair"], found["machine"]
    lines = [
        "# Computational cost",
        "",
        f"{facts['machine']}, shared, load {facts['load']}. Source {found['source']}, {found['rows'][0]['pairs']} training pairs. CPU "
        "seconds of one thread, each method in a process of its own; the head's epochs are means of "
        f"{HEAD_EPOCHS}. Memory: peak of the process, and what the fit added to it. FPS: pairs a second, "
        "one after another. With the encoder: EfficientNet-Lite0 in front, "
        f"{1000 * encoder:.0f} ms a pair, preprocessing not counted. Command: `python -m benchmarks.cost`.",
        "",
        "| method | parameters | s an epoch | whole fit, s | peak memory (added), MB | FPS from "
        "embeddings | FPS with the encoder |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for row in found["rows"]:
        epoch = "–" if row["epoch_s"] is None else f"{row['epoch_s']:.2f}"
        whole = "–" if row["fit_s"] is None else f"{row['fit_s']:.1f}"
        lines.append(
            f"| {row['label']} | {row['parameters']:,} | {epoch} | {whole} | {row['peak_mb']} "
            f"({row['memory_mb']}) | {1 / row['pair_s']:.0f} | {1 / (row['pair_s'] + encoder):.1f} |"
        )
    return "\n".join(lines) + "\n" + printed()


def printed() -> str:
    """Return the paper's table: another machine (an RTX 3090), encoder and data."""
    from omnivat.study.reports.paper import paper

    names = list(next(iter(paper()["cost"].values())))
    lines = [
        "",
        "## Printed (RTX 3090, CLIP ViT-B/16 and disk included; not comparable)",
        "",
        "| method | " + " | ".join(names) + " |",
        "| --- |" + " --- |" * len(names),
    ]
    for method, row in paper()["cost"].items():
        cells = ["–" if value is None else f"{value:,.1f}" for value in row.values()]
        lines.append(f"| {method} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    run()
