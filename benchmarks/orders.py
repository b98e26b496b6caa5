"""Does the order search know where it is unsure? Writes docs/benchmarks/orders.json.

    python -m benchmarks.orders [--draws 40] [--first 2000]

Chirps of a second program (`_other_chirps`): interference from 0.1 of p*, one modality without a
signal in two draws of five. For each number of pairs and width, by the standard errors that a tie
may have:

near   the order found is within 0.015 of p*
told   p* lies in the stated range, or within a valley (4 / D) of an order that is said to tie
sure   no order of another valley is said to tie
wrong  sure, and p* is not told
width  median width of the stated range

The last line is the search on the shipped chirps (p* = 0.35, 100 pairs).
"""

import argparse
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._other_chirps import drawn, embeddings_of
from omnivat.data.embeddings import Embeddings
from omnivat.data.store import load_embeddings
from omnivat.head.settings import HeadSettings
from omnivat.kit.files import write_json
from omnivat.kit.threads import pin_thread
from omnivat.training import TrainSettings, Watch, order_search

PAIRS, WIDTHS, DOUBTS = (30, 60, 100), (32, 64, 96), (2.0, order_search.DOUBT)
NEAR = 0.015
RECORD = Path("docs/benchmarks/orders.json")
SHIPPED = Path("examples/chirps/chirps.safetensors")


def searched(source: Embeddings, doubt: float, **head: Any) -> dict[str, Any]:
    """Return the record of a search whose ties may be this many standard errors worse."""
    order_search.DOUBT = doubt
    width = source.width
    settings = HeadSettings(
        classes=tuple(source.header.classes), input_width=width, lang_width=1, width=width, **head
    )
    return order_search.search_order(source, settings, TrainSettings(), seed=0, watch=Watch())


def draws(pairs: int, width: int, seeds: range, doubt: float) -> Iterator[dict[str, float]]:
    """Yield what the search of each draw says, beside its p*."""
    for seed in seeds:
        recipe = drawn(seed, pairs=pairs, width=width)
        made = embeddings_of(recipe)
        record = searched(made.select(np.flatnonzero(made.domain == 0)), doubt, standardize=False)
        low, high = record["between"]
        miss = min((abs(p - recipe.order) for p in record["ties"]), default=np.inf)
        told = low - 1e-4 <= recipe.order <= high + 1e-4 or miss <= order_search.APART / width
        sure = not record["ties"]
        yield {
            "near": abs(record["start"] - recipe.order) <= NEAR,
            "told": told,
            "sure": sure,
            "wrong": sure and not told,
            "width": high - low,
            "error": abs(record["start"] - recipe.order),
        }


def main() -> None:
    """Measure every cell and print it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--draws", type=int, default=40, help="of each number of pairs and width")
    parser.add_argument("--first", type=int, default=2000, help="seed of the first draw")
    parser.add_argument("--out", type=Path, default=RECORD, help="the record")
    options = parser.parse_args()
    pin_thread()
    rows = []
    for pairs, width, doubt in product(PAIRS, WIDTHS, DOUBTS):
        seeds = range(options.first, options.first + options.draws)
        found = list(draws(pairs, width, seeds, doubt))
        row: dict[str, Any] = {"pairs": pairs, "width": width, "doubt": doubt, "draws": len(found)}
        row |= {key: sum(one[key] for one in found) for key in ("near", "told", "sure", "wrong")}
        row["range"] = round(float(np.median([one["width"] for one in found])), 4)
        missed = [one["error"] for one in found if not one["told"]]
        row["largest error not told"] = round(max(missed, default=0.0), 4)
        rows.append(row)
        print(*(f"{key} {value}" for key, value in row.items()), sep=", ", flush=True)
    source = load_embeddings(SHIPPED).in_domain("Chirps A-sim", split="train")
    record = searched(source, order_search.DOUBT, theta_init="signed")
    shipped = {key: record[key] for key in ("start", "between", "ties", "note")}
    print(shipped["note"])
    write_json(options.out, {"rows": rows, "shipped": shipped})


if __name__ == "__main__":
    main()
