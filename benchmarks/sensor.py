"""The sensor card on simulated gels of which one known part was changed.

    python -m benchmarks.sensor [--draw 0 1] [--touches 10 25] [--gels DIGIT] [--only "by 180°"]
    python -m benchmarks.sensor --gel-traits

Each draw presses other objects into a gel for two folders. The second is imaged again with each
change of CHANGES, and its card is compared with that of the first. A row of the record holds what
was named at one number of touches; a row that is there is not computed again. The table is of the
whole record: the share of pairs of folders in which the part is named first, with Wilson's 95 %
interval. `python -m benchmarks.table_text` writes it into docs/sensor.md. `--gel-traits` prints
grain and sharpness of the gels as they are (`omnivat.measure.card.report.GELS`).
"""

import argparse
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby, takewhile
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks._machine import machine
from benchmarks._markdown import table
from omnivat.kit.seeding import derive_seed
from omnivat.kit.threads import pin_thread
from omnivat.measure.card.card import card_of, summed
from omnivat.measure.card.changes import changes_between
from omnivat.measure.card.traits import traits_of
from simulator.contact import pressed_gel
from simulator.domains import SIMULATED
from simulator.drawing import pressing
from simulator.plan import planned
from simulator.sensors import GELS, Lamp, Markers, Sensor
from simulator.tactile import imaged, used
from simulator.things import thing

Picture = NDArray[np.uint8]
RECORD = Path(__file__).resolve().parents[1] / "docs" / "benchmarks" / "sensor.jsonl"
MATERIALS = ("wood", "steel", "plastic", "ceramic", "glass")
COUNTS = (10, 25, 100)
SIZE = 224  # pixels
FOLDERS = 200_000  # number of the first object; folders are APART
APART = 1_000


class Change(NamedTuple):
    """A part of a gel, how much it changes, and how."""

    part: str
    words: str
    sensor: Callable[[Sensor], Sensor] = lambda gel: gel
    picture: Callable[[Picture], Picture] = lambda picture: picture


def _of(name: str, part: str, words: str, factor: float) -> Change:
    """Return the change of a number of the gel by a factor."""
    return Change(part, words, lambda gel: replace(gel, **{name: factor * getattr(gel, name)}))


def _turned(angle: float) -> Change:
    def sensor(gel: Sensor) -> Sensor:
        lamps = [Lamp(lamp.azimuth + angle, lamp.colour, lamp.spill) for lamp in gel.lamps]
        return replace(gel, lamps=tuple(lamps))

    return Change("lamps", f"turned by {angle:.0f}°", sensor)


def _weak(share: float) -> Change:
    def sensor(gel: Sensor) -> Sensor:
        first, *rest = gel.lamps
        red, green, blue = first.colour
        colour = (share * red, share * green, share * blue)
        return replace(gel, lamps=(Lamp(first.azimuth, colour, first.spill), *rest))

    return Change("lamps", f"one at {100 * share:.0f} %", sensor)


def _tint(step: float) -> Change:
    def sensor(gel: Sensor) -> Sensor:
        red, green, blue = gel.base
        return replace(gel, base=(red + step, green, blue - step))

    return Change("tint", f"redder by {step:.2f}", sensor)


def _blur(more: float) -> Change:
    return Change(
        "sharpness", f"less by {more:g} pixels", lambda gel: replace(gel, blur=gel.blur + more)
    )


def _crop(share: float) -> Change:
    from PIL import Image

    def picture(whole: Picture) -> Picture:
        rim = round(SIZE * (1 - share) / 2)
        inner = Image.fromarray(whole[rim:-rim, rim:-rim])
        return np.asarray(inner.resize((SIZE, SIZE), Image.Resampling.BICUBIC))

    return Change("scale", f"cropped to {100 * share:.0f} %", picture=picture)


DOTS = Markers(pitch=2.0, radius=0.28, uneven=0.06)
CHANGES = (
    Change("", "nothing"),
    Change("channels", "red and blue swapped", picture=lambda picture: picture[..., ::-1]),
    Change("mirrored", "left to right", picture=lambda picture: picture[:, ::-1]),
    Change("turned", "by 180°", picture=lambda picture: picture[::-1, ::-1]),
    *map(_turned, (50, 20, 10)),
    *map(_weak, (0.35, 0.6, 0.8)),
    Change("dots", "gained", lambda gel: replace(gel, markers=DOTS)),
    Change("dots", "lost", lambda gel: replace(gel, markers=None)),
    *map(_tint, (0.14, 0.05, 0.02)),
    *(_of("gain", "strength", f"at {100 * share:.0f} %", share) for share in (0.55, 0.75, 0.85)),
    *map(_blur, (3.0, 2.0, 1.2)),
    *(_of("noise", "noise", f"× {factor}", factor) for factor in (3, 1.6, 1.3)),
    *map(_crop, (0.65, 0.8)),
)


def fits(change: Change, gel: Sensor) -> bool:
    """Return whether a gel can change so: dots come where none are, and go, or scale, where all
    pictures have them."""
    dotted = gel.markers is not None
    if change.words == "gained":
        return not dotted
    return not (change.words == "lost" or change.part == "scale") or (dotted and not gel.plain_gels)


class Pressed:
    """A folder of presses, to be imaged by gels of one shape: (sheet, shear, seed) of each."""

    def __init__(self, gel: Sensor, folder: int, count: int) -> None:
        domain = replace(SIMULATED["TAG"], seed_base=FOLDERS + APART * folder)
        each = -(-count // len(MATERIALS))
        plans = [planned(domain, material, pairs=60) for material in MATERIALS]
        self.presses = []
        for plan in [plans[k % 5][k // 5] for k in range(5 * each)][:count]:
            stream = derive_seed(0, "pair", plan.domain, plan.material, plan.object, plan.number)
            press = pressing(np.random.default_rng(derive_seed(stream, "press")))
            seed = derive_seed(stream, "sensor")
            worn = used(gel, np.random.default_rng(derive_seed(seed, "gel")))
            sheet = pressed_gel(thing(plan, seed=0), press, worn, size=SIZE)
            self.presses.append((sheet, press.shear, seed))

    def seen(self, gel: Sensor) -> list[Picture]:
        """Return the pictures (SIZE, SIZE, 3) of a gel."""
        pictures = []
        for sheet, shear, seed in self.presses:
            worn = used(gel, np.random.default_rng(derive_seed(seed, "gel")))
            image = 255 * imaged(sheet, worn, shear, seed=seed)
            pictures.append(np.rint(image).astype(np.uint8))
        return pictures


def rows_of(
    name: str, draw: int, counts: Sequence[int], only: Sequence[str]
) -> list[Mapping[str, Any]]:
    """Return a row of the record for each number of touches of one gel; `only` some changes."""
    gel, most = GELS[name], max(counts)
    place = 2 * (draw * len(GELS) + list(GELS).index(name))
    before, after = (Pressed(gel, place + k, most) for k in (0, 1))
    plain = [traits_of(picture) for picture in before.seen(gel)]
    old = {count: summed(plain[:count]) for count in counts}
    untouched = after.seen(gel)
    found: dict[int, dict[str, list[str]]] = {count: {} for count in counts}
    seconds: dict[int, list[float]] = {count: [] for count in counts}
    for change in CHANGES:
        if not fits(change, gel) or change.words not in only:
            continue
        seen = untouched if change.sensor(gel) == gel else after.seen(change.sensor(gel))
        began = process_time()
        read = [traits_of(np.ascontiguousarray(change.picture(picture))) for picture in seen]
        each = (process_time() - began) / most
        for count in counts:
            began = process_time()
            changes = changes_between(old[count], summed(read[:count]))
            found[count][f"{change.part} {change.words}"] = [named.part for named in changes]
            seconds[count].append(count * each + process_time() - began)
    return [
        {"gel": name, "draw": draw, "touches": count, "seconds": round(median(seconds[count]), 2),
         "named": found[count]}
        for count in counts
    ]  # fmt: skip


def interval(right: int, of: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share.

    >>> [round(end, 2) for end in interval(0, 30)]
    [0.0, 0.11]
    """
    z = 1.96
    middle, width = right + z * z / 2, z * np.sqrt(right * (of - right) / of + z * z / 4)
    return max(0.0, (middle - width) / (of + z * z)), min(1.0, (middle + width) / (of + z * z))


def recorded(file: Path = RECORD) -> list[Mapping[str, Any]]:
    """Return the rows of a record, none if there is no file."""
    text = file.read_text(encoding="utf-8") if file.is_file() else ""
    return [json.loads(line) for line in text.splitlines()]


def report(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the record as Markdown: the changes of a part in a line, numbers of touches in
    columns; then the interval of each share.
    """
    counts = sorted({row["touches"] for row in rows})
    lines = []
    shares: set[tuple[int, int]] = set()
    for (part, _), some in groupby(CHANGES, lambda change: (change.part, change.words.split()[0])):
        kind, cells = [*some], []
        for count in counts:
            found = [named_first(rows, change, count) for change in kind]
            shares.update(share for share in found if share[1])
            texts = [f"{right}/{of}" if of else "–" for right, of in found]
            cells.append(", ".join(texts) if {*texts} != {"–"} else "–")
        first, *others = (change.words.split() for change in kind)
        start = len([*takewhile(lambda same: len({*same}) == 1, zip(first, *others, strict=False))])
        words = "; ".join(
            " ".join(parts) for parts in (first, *(other[start:] for other in others))
        )
        lines.append([f"{part} {words}".strip(), *cells])
    ends = [
        f"{right}/{of} {100 * low:.0f}–{100 * high:.0f}"
        for right, of in sorted(shares, key=lambda share: (-share[1], share[0]))
        for low, high in [interval(right, of)]
    ]
    text = table(["changed", *(f"{count} touches" for count in counts)], lines, "---")
    return f"{text}\n\nWilson's 95 % intervals (%): {', '.join(ends)}."


def named_first(rows: Sequence[Mapping[str, Any]], change: Change, count: int) -> tuple[int, int]:
    """Return in how many pairs of folders a change is named first, and how many pairs there are."""
    key = f"{change.part} {change.words}"
    lists = [row["named"][key] for row in rows if row["touches"] == count and key in row["named"]]
    return sum((parts or [""])[0] == change.part for parts in lists), len(lists)


def spent(rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield the time of a card at each count of touches, as a sentence."""
    for count in sorted({row["touches"] for row in rows}):
        each = sorted(row["seconds"] for row in rows if row["touches"] == count)
        yield f"{count} touches: {median(each):.1f} s, {each[0]:.1f} to {each[-1]:.1f}."


def gel_traits() -> None:
    """Print grain, of 255, and sharpness of the simulated gels."""
    for name, gel in GELS.items():
        card = card_of(Pressed(gel, 900, 50).seen(gel))
        grain, sharp = (float(np.exp(card.of(row)[0])) for row in ("noise", "sharpness"))
        print(f'    "{name}": ({grain:.1f}, {sharp:.2f}),')


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--record", type=Path, default=RECORD)
    parser.add_argument("--gels", nargs="*", choices=GELS, default=list(GELS))
    parser.add_argument("--draw", nargs="*", type=int, default=[])
    parser.add_argument("--touches", nargs="+", type=int, default=COUNTS)
    parser.add_argument("--only", nargs="+", default=[change.words for change in CHANGES])
    parser.add_argument("--gel-traits", action="store_true")
    options = parser.parse_args(arguments)
    pin_thread()
    if options.gel_traits:
        return gel_traits()
    rows = recorded(options.record)
    there = {(row["gel"], row["draw"], row["touches"]) for row in rows}
    for draw in options.draw:
        for name in options.gels:
            counts = [count for count in options.touches if (name, draw, count) not in there]
            for row in rows_of(name, draw, counts, options.only) if counts else []:
                rows.append(row)
                with options.record.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(row, ensure_ascii=False) + "\n")
    print(report(rows), "", *spent(rows), machine(), sep="\n")


if __name__ == "__main__":
    main()
