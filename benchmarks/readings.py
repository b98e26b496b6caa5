"""How touch is read: what a gel costs in colours, by relief and by both, and what Tac3D gives.

    python -m benchmarks.readings gels FOLDER    docs/twins.md, by relief; the twins' folder
    python -m benchmarks.readings tac3d FOLDER   docs/relief.md, Tac3D; the simulated set's folder

Gels: presses by five gels, touch alone, dots filled. The plain head of `benchmarks.twins` learns
the training pairs of one gel and reads the presses of each; lamps and a profile of 20 come from
presses of the other two thirds. *Both* is the vector of `embed --touch both`. What the sensor costs
is the accuracy on the own gel less that on the four others; 95 % intervals draw sources and
objects.
"""

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._markdown import table
from benchmarks._table_record import Array, Record
from benchmarks._twins_heads import learned, predicted, unit
from benchmarks.relief import Drawn, Reliefs, Wide
from benchmarks.twins import by_relief, picture
from omnivat.data.domains import paper_name
from omnivat.data.dots import fill_dots
from omnivat.data.relief import lamps, slopes
from omnivat.data.relief.filters import fast
from omnivat.data.store import load_embeddings
from omnivat.encoders import load_encoder
from omnivat.head.heads import RELIEF, default_embeddings
from omnivat.kit.threads import pin_thread
from omnivat.measure.twins import Twins, twins
from simulator.domains import SIMULATED
from simulator.sensors import Sensor
from simulator.twins import unmet_objects

DRAWS = 2000
SOME = 20  # pictures that give lamps and a profile
# reading -> what is known of the target, pictures that give lamps, and pictures of the profile
KNOWN = {
    "colours": (("nothing", 0, 0), ("profile of 20", 0, SOME)),
    "relief": (
        ("nothing", 0, 0),
        ("lamps of 20", SOME, 0),
        ("lamps and profile of 20", SOME, SOME),
    ),
}
KNOWN["both"] = KNOWN["relief"]
TAC3D = "TQ-T3D-sim"
POOL, MOVED = 120, 40  # touches that give lamps in draws; others whose slopes are compared
TO_MOTION = np.array([[-1, 0], [0, 1], [0, 0]]) / 2**0.5  # red is rightward motion, green upward


def gels(made: Twins) -> list[str]:
    """Return the domains whose sensor is a gel under lamps, drawn by the simulator's own model."""
    domains = made.header.domains
    return [n for n in domains if isinstance(SIMULATED[paper_name(n)].sensor, Sensor)]


def right(
    made: Twins, learning: Mapping[str, Any], lit: Mapping[str, Array], reading: str, known: Any
) -> dict[tuple[str, str], Array]:
    """Return (source, target) -> which presses of the source's classes are right.

    learning  reading -> the set that heads learn from
    lit       gel -> `by_relief` of its presses (2, PARTS, N, W): each alone, by lamps of 20
    known     pictures that give lamps, and pictures of the profile
    """

    def rows(name: str, pictures: int) -> Array:
        drawn = lit[name][int(pictures > 0)]
        filled = np.broadcast_to(made.filled[:, made.place(name)], drawn.shape)
        parts = {"colours": (filled,), "relief": (drawn,), "both": (filled, drawn)}[reading]
        return unit(np.concatenate(parts, -1))

    found, classes = {}, len(made.header.classes)
    for source in lit:
        own = learning[reading].in_domain(source, split="train")
        head = learned(unit(np.asarray(own.tac, np.float32)), own.label)
        tested = np.isin(made.label, own.label)
        for target in lit:
            profile = 0 if source == target else known[1]  # the head has the source's own
            shares = predicted(head, rows(target, known[0]), profile, classes, seed=0)
            answers = head.model.classes_[shares.argmax(1)]
            found[source, target] = (answers == made.label)[tested]
    return found


def cost(right: Mapping[tuple[str, str], Array]) -> tuple[float, float, Array]:
    """Return percent right on the own gel and on others, and the cost (3,) with its interval."""
    names = list(dict.fromkeys(source for source, _ in right))
    own = [right[n, n] for n in names]
    away = [np.mean([right[n, m] for m in names if m != n], axis=0) for n in names]
    lost, random = [a - b for a, b in zip(own, away, strict=True)], np.random.default_rng(0)

    def draw() -> float:
        some = (lost[k] for k in random.integers(len(lost), size=len(lost)))
        return float(
            np.mean(
                [values[random.integers(len(values), size=len(values))].mean() for values in some]
            )
        )

    limits = np.quantile([draw() for _ in range(DRAWS)], [0.025, 0.975])
    home, others = (
        100 * float(np.mean([values.mean() for values in some])) for some in (own, away)
    )
    return home, others, np.array([home - others, *(100 * limits)])


def of_gels(folder: Path) -> str:
    """Return the table of docs/twins.md."""
    made, filled = twins(), load_embeddings(default_embeddings())
    relief, encoder, lit = Reliefs(filled), load_encoder("efficientnet-lite0"), {}
    for name in gels(made):
        domain = SIMULATED[paper_name(name)]
        touches = [fill_dots(picture(folder, unmet, domain))[0] for unmet in unmet_objects()]
        count = len(touches), len(made.header.classes)
        lit[name] = by_relief(touches, *count, encoder, (0, SOME))
        print(name, flush=True)
    learning = {"colours": filled, "relief": relief.source, "both": Wide(relief).source}
    rows = []
    for reading, every in KNOWN.items():
        for words, *known in every:
            home, others, (loss, *limits) = cost(right(made, learning, lit, reading, known))
            low, high = (f"{limit:.1f}".replace("-", "−") for limit in limits)
            figures = f"{home:.1f}", f"{others:.1f}", f"{loss:.1f} ({low} to {high})"
            rows.append([reading, words, *figures])
    return table(
        ["read by", "known of the target", "own gel", "other gels", "the sensor costs"], rows
    )


def of_tac3d(folder: Path) -> Iterator[str]:
    """Yield what displacements drawn as colours give for lamps, slopes, and accuracy."""
    held = Drawn(load_embeddings(default_embeddings()), folder)
    rows = np.random.default_rng(0).permutation(held.set.rows_of(TAC3D))[: POOL + MOVED]
    touches = [held.picture(row) for row in rows]
    found = []
    for seed in range(10):
        some = np.random.default_rng(seed).permutation(POOL)[:SOME]
        found.append(lamps([touches[i] for i in some], dots="keep"))
    alike = [float((g.colours * TO_MOTION).sum() / np.linalg.norm(g.colours)) for g in found]
    yield (
        f"Lamps of {SOME}, ten draws of {POOL} touches: cosine to −red for right, green for down:"
        f" median {np.median(alike):.3f}, lowest {min(alike):.3f}; median ratio"
        f" {np.median([g.ratio for g in found]):.2f}"
    )
    same = np.zeros((MOVED, 2))
    for k, touch in enumerate(touches[POOL:]):
        steep, moved = slopes(touch, found[0], dots="keep"), fast(touch.astype(np.float32))
        for axis, sign in enumerate((-1, 1)):
            pair = steep[..., axis].ravel(), sign * moved[..., axis].ravel()
            same[k, axis] = np.corrcoef(*pair)[0, 1]
    red, green = same.mean(0)
    yield f"Slopes of {MOVED} others: correlation {red:.2f} with −red, {green:.2f} with green"
    records = Record(RELIEF), Record()
    place = records[0].domains.index(TAC3D)
    for words, rung in (("nothing known", "none"), ("lamps and profile of 20", "n20")):
        cells = [record.cells(rung)["linear_maps"][:, place] for record in records]
        seeds = min(cell.shape[1] for cell in cells)
        lit, plain = (float(np.nanmean(cell[:, :seeds])) for cell in cells)
        yield f"Linear maps, {words}: {lit:.1f} % by relief, {plain:.1f} in colours"


def main() -> None:
    """Print what was measured."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("gels", "tac3d"))
    parser.add_argument("folder", type=Path)
    options = parser.parse_args()
    pin_thread()
    lines = [of_gels(options.folder)] if options.what == "gels" else of_tac3d(options.folder)
    print(*lines, sep="\n")


if __name__ == "__main__":
    main()
