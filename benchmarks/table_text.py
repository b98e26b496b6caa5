"""The table of results from its record: docs/benchmarks/table.md and .svg, the README between its
markers.

    python -m benchmarks.table_text [--check]

It also writes the tables of docs/new-sensor.md, docs/protocol.md and docs/sensor.md, the first
finding of the README and the findings of the report. A cell is accuracy in percent: the mean over
sources of the mean over targets, over seeds. Its 95 % interval draws sources, then the targets of
each, then seeds, all with replacement (10,000 draws). A difference is paired: both methods have the
same source, target and seed. The mean of several heads has no seed to draw, and there is one set,
so sets are not drawn.

docs/benchmarks/chirps.jsonl.gz is `runs.jsonl` of

    python -m omnivat protocol --embeddings examples/chirps/chirps.safetensors --out DIR \\
        --methods omnivat,omnivat_p0,linear_maps,erm_mlp,nearest_mean --seeds 0,1,2 \\
        --set width=64 --set theta_init=signed --set lang=false --set epochs=40 \\
        --set order_search=true
"""

import argparse
import json
import re
import sys
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks import sensor
from omnivat.figures.scores import ladder
from omnivat.figures.still import svg_of
from omnivat.head.heads import LADDERS, RELIEF
from omnivat.kit.files import write_text
from omnivat.kit.lines import lines
from omnivat.measure.ladder import FORMAT, letters, marks
from omnivat.measure.rungs import RUNGS as ROWS
from omnivat.study.protocol.records import FORMAT as RUN

ROOT = Path(__file__).resolve().parents[1]
RECORDS = ROOT / "docs" / "benchmarks"
PAGE = RECORDS / "table.md"
CHIRPS = RECORDS / "chirps.jsonl.gz"
MARKS = ("<!-- table -->", "<!-- end of table -->")
FINDINGS = ("<!-- findings -->", "<!-- end of findings -->")
RUNGS = {"none": "as it comes", "n5": "5 pictures", "n20": "20 pictures", "k5": "5 labels a class"}
LIT = {  # rungs of the relief -> words, and the rung at which colours know as much
    "home": ("home", "home"),
    "none": ("as it comes", "none"),
    "l5": ("lamps of 5", "none"),
    "n5": ("lamps and profile of 5", "n5"),
    "l20": ("lamps of 20", "none"),
    "n20": ("lamps and profile of 20", "n20"),
    "k5": ("5 labels a class", "k5"),
    "tac": ("touch, as it comes", "tac"),
    "l20, touch": ("touch, lamps of 20", "tac"),
}
READINGS = {"none": "both", "vis": "photo alone", "tac": "touch alone"}
NAMES = {
    "linear_maps": "Linear maps of photo, touch and both",
    "logistic": "Logistic regression (the map of both alone)",
    "omnivat": "OmniVaT, the page's recipe",
    "dtg": "OmniVaT's tree alone (DTG)",
    "erm_mlp": "ERM-MLP",
    "nearest_mean": "Nearest class mean",
    "vt_cmc_head": "VT CMC, head alone",
    "ldc_icd": "LDC, logit de-confusion alone",
    "baseline": "The paper's Baseline and PromptStyler row",
    "sitr_supcon": "SITR's head, touch alone",
}
NEEDED = {  # methods of the paper that these sets and this encoder do not give
    "SPG": "CLIP's image and text towers",
    "MMRL": "CLIP's two towers and the pictures",
    "LDC whole": "CLIP's image tower and the pictures",
    "PromptStyler, source-free": "a text tower of the image encoder",
    "CLIP zero-shot": "a text tower of the image encoder",
    "VT CMC whole": "an encoder that is pre-trained on touch",
    "SITR whole": "its own transformer and calibration presses",
    "RobustVisH": "a kinaesthetic branch, and half an hour of training a source",
}
# rows of the README
SHOWN = ("erm_mlp", "linear_maps", "omnivat", "nearest_mean", "baseline")
HOME = "OmniVaT without training noise"  # the better of both on real pairs
FEW = (10, 20)  # training pairs of each class
DRAWS = 10_000
Array = NDArray[Any]
# method -> accuracy in percent (sources, targets, seeds); NaN where absent
Cells = dict[str, Array]


class Record:
    """The record's accuracies by method, rung, source, target and seed."""

    def __init__(self, file: Path = LADDERS) -> None:
        first, *runs = lines(file, FORMAT)
        self.runs = runs
        self.domains = first["domains"]
        self.domain = np.array(first["domain"])
        self.truth = letters(first["truth"])
        self.alike = np.array([one == "1" for one in first["look_alike"]])

    def cells(self, rung: str, *, alike: bool = False) -> Cells:
        """Return accuracies of a rung; `alike`: of the pairs that look like another class only."""
        found: dict[str, dict[tuple[int, int, int], float]] = defaultdict(dict)
        for run in (one for one in self.runs if rung in one["answers"]):
            source = self.domains.index(run["source"])
            known = np.isin(self.truth, self.truth[self.domain == source])
            counted = known & self.alike if alike else known
            right = np.where(counted, marks(run["answers"][rung], self.truth), np.nan)
            for target in range(len(self.domains)):
                rows = right[(self.domain == target) & ~np.isnan(right)]
                if (target == source) == (rung == "home") and len(rows):
                    found[run["method"]][source, target, run["seed"]] = 100 * float(rows.mean())
        shape = len(self.domains), len(self.domains)
        tables = {}
        for name, values in found.items():
            seeds = sorted({seed for *_, seed in values})
            tables[name] = np.full((*shape, len(seeds)), np.nan)
            for (source, target, seed), value in values.items():
                tables[name][source, target, seeds.index(seed)] = value
        return tables


def by_relief(record: Record, relief: Record) -> list[str]:
    """Return readings by relief, and in brackets their gain over colours that know as much."""
    text = [
        f"| method | seeds | {' | '.join(words for words, _ in LIT.values())} |",
        "| --- | ---: |" + " ---: |" * len(LIT),
    ]
    lit = {rung: relief.cells(rung) for rung in LIT}
    plain = {rung: record.cells(rung) for _, rung in LIT.values()}
    for name in sorted(lit["n20"], key=lambda name: -interval(lit["n20"][name])[0]):
        row = [NAMES[name], str(lit["n20"][name].shape[2])]
        for rung, (_, base) in LIT.items():
            if name in lit[rung]:
                gain = less(lit[rung][name], plain[base][name])
                row.append(f"{interval(lit[rung][name])[0]:.1f} ({gain})")
            else:
                row.append("–")
        text.append(f"| {' | '.join(row)} |")
    return text


def leads_by_relief(relief: Record) -> list[str]:
    """Return OmniVaT minus each other method, both by relief."""
    rungs = {rung: words for rung, (words, _) in LIT.items() if "," not in words}
    text = [f"| OmniVaT minus | {' | '.join(rungs.values())} |", "| --- |" + " ---: |" * len(rungs)]
    lit = {rung: relief.cells(rung) for rung in rungs}
    for name in lit["n20"]:
        if name != "omnivat":
            row = [less(cells["omnivat"], cells[name]) for cells in lit.values()]
            text.append(f"| {NAMES[name]} | {' | '.join(row)} |")
    return text


def interval(cells: Array) -> tuple[float, float, float]:
    """Return mean and 95 % interval of accuracies (sources, targets, seeds).

    A level of one value, such as the seed of a mean of several heads, is not drawn.
    """
    random = np.random.default_rng(0)
    mean = float(np.nanmean(np.nanmean(cells, axis=(1, 2))))
    there = np.asarray(~np.isnan(cells).all(axis=2))
    targets = there.sum(1).min()  # the home cell of each source is empty
    dense = np.stack([cells[s][there[s]][:targets] for s in range(len(cells))])
    sources, _, seeds = dense.shape
    some = random.integers(sources, size=(DRAWS, sources))
    drawn = random.integers(targets, size=(DRAWS, sources, targets))
    seed = random.integers(seeds, size=(DRAWS, sources, 1, seeds))
    values = dense[some[..., None, None], drawn[..., None], seed]
    low, high = np.quantile(np.nanmean(values, axis=(1, 2, 3)), [0.025, 0.975])
    return mean, float(low), float(high)


def facts(runs: Sequence[Mapping[str, Any]], name: str) -> tuple[str, str, int]:
    """Return seconds of a training, number of parameters, and seeds, for the columns beside."""
    own = [run for run in runs if run["method"] == name]
    timed = [
        run for run in runs if run["method"] == ("linear_maps" if name == "logistic" else name)
    ]
    seconds = np.median([run["seconds"] for run in timed])  # the two share one fit
    parameters = np.median([run["parameters"] for run in own])
    return f"{seconds:.0f}", f"{parameters:,.0f}", len({run["seed"] for run in own})


def complete(record: Record) -> list[str]:
    """Return the methods of which every source was measured, best first as they come."""
    sources = {name: {r["source"] for r in record.runs if r["method"] == name} for name in NAMES}
    cells = record.cells("none")
    there = [name for name, found in sources.items() if len(found) == len(record.domains)]
    return sorted(there, key=lambda name: -np.nanmean(np.nanmean(cells[name], axis=(1, 2))))


def main_table(record: Record, only: Sequence[str] = ()) -> list[str]:
    """Return the table of results: methods by rungs, one head and the mean of several.

    only  some of the methods; (): all
    """
    text = [
        (
            f"| method | seeds | {' | '.join(RUNGS.values())} | all seeds averaged, as it comes |"
            " seconds | numbers |"
        ),
        "| --- | ---: |" + " ---: |" * (len(RUNGS) + 3),
    ]
    tables = {rung: record.cells(rung) for rung in RUNGS}
    for name in complete(record):
        if only and name not in only:
            continue
        row = [NAMES[name]]
        seconds, numbers, seeds = facts(record.runs, name)
        row.append(str(seeds))
        row += [told(cells[name]) for cells in tables.values()]
        several = tables["none"].get(f"{name}_mean")
        row.append("–" if several is None else told(several))
        text.append(f"| {' | '.join([*row, seconds, numbers])} |")
    return text


def told(cells: Array) -> str:
    """Return accuracy with its interval."""
    mean, low, high = interval(cells)
    return f"{mean:.1f} [{low:.1f}, {high:.1f}]"


def averaged(record: Record) -> list[str]:
    """Return the mean of all heads of a method as it comes, beside one head.

    Each seed draws other known pairs, so a mean of heads with a profile would know more of them.
    """
    text = ["| method | heads | one head | their mean | gain |", "| --- | ---: |" + " ---: |" * 3]
    cells = record.cells("none")
    heads = {r["method"]: r["heads"] for r in record.runs}
    for name in complete(record):
        if (several := f"{name}_mean") in heads:
            one = cells[name].mean(axis=2, keepdims=True)
            row = [told(cells[name]), told(cells[several]), less(cells[several], one)]
            text.append(f"| {NAMES[name]} | {heads[several]} | {' | '.join(row)} |")
    return text


def chirps() -> dict[str, Array]:
    """Return method -> accuracies (sources, targets, seeds) on the shipped chirps."""
    runs = list(lines(CHIRPS, RUN))
    names = sorted({run["source"] for run in runs})
    seeds = sorted({run["seed"] for run in runs})
    found = {run["method"]: np.full((len(names), len(names), len(seeds)), np.nan) for run in runs}
    for run in runs:
        table = found[run["method"]][names.index(run["source"])]
        for target, scores in run["targets"].items():
            right = 100 * scores["scores"]["fused"]["accuracy"]
            table[names.index(target), seeds.index(run["seed"])] = right
    return found


def twins() -> dict[str, Array]:
    """Return method -> accuracies (sources, 1, 1) on twins: the sensor alone changed, touch alone.

    Dots are filled; sources are those that both methods learned.
    """
    split = json.loads((RECORDS / "twins.json").read_text(encoding="utf-8"))["split"]
    by_source = {m: split[m]["filled"]["touch"]["by_source"] for m in ("omnivat", "linear_maps")}
    shared = [source for source in by_source["omnivat"] if source in by_source["linear_maps"]]
    return {
        m: np.array([of[s]["home"] - of[s]["new_objects"] - of[s]["sensor"] for s in shared])[
            :, None, None
        ]
        for m, of in by_source.items()
    }


def real() -> dict[str, Any]:
    """Return what -> record of the real pairs of VT60."""
    records = json.loads((RECORDS / "real.json").read_text(encoding="utf-8"))["records"]
    return {one["what"]: one for one in records if one["part"] == "vt60"}


def good_for(record: Record) -> list[str]:
    """Return where OmniVaT was compared with the linear maps, a row each."""
    cells = {rung: record.cells(rung) for rung in ("none", "vis", "tac")}
    none, alike = cells["none"], record.cells("none", alike=True)
    ours, theirs = "omnivat", "linear_maps"
    compared = {"chirps, p searched": (chirps()[ours], chirps()[theirs])}
    compared["chirps, p = 0"] = (chirps()["omnivat_p0"], chirps()[theirs])
    of_twins = twins()
    compared["twins: the sensor alone changed, by touch"] = of_twins[ours], of_twins[theirs]
    for count in FEW:
        compared[f"{count} pairs of each class"] = (
            none[f"{ours}@{count}"],
            none[f"{theirs}@{count}"],
        )
    compared["all pairs, 40 of each class"] = (none[ours], none[theirs])
    compared["touch missing"] = (cells["vis"][ours], cells["vis"][theirs])
    compared["photo missing"] = (cells["tac"][ours], cells["tac"][theirs])
    compared["look-alikes"] = (alike[ours], alike[theirs])
    if f"{ours}_mean" in none:
        compared["all seeds averaged"] = (none[f"{ours}_mean"], none[f"{theirs}_mean"])
    text = [
        "| where | OmniVaT | linear maps | OmniVaT minus linear maps |",
        "| --- | ---: | ---: | ---: |",
    ]
    for where, (a, b) in compared.items():
        means = [f"{interval(x)[0]:.1f}" for x in (a, b)]
        text.append(f"| {where} | {' | '.join(means)} | {less(a, b)} |")
    told_real = real()
    one = told_real[f"{HOME} less linear maps"]
    means = [f"{100 * told_real[name]['value']:.1f}" for name in (HOME, "linear maps")]
    ends = [100 * one[key] for key in ("value", "low", "high")]
    lead = f"{ends[0]:+.1f} [{ends[1]:.1f}, {ends[2]:.1f}]".replace("-", "−")
    return [*text, f"| real pairs, VT60, objects held out | {' | '.join(means)} | {lead} |"]


def not_measured() -> list[str]:
    """Return the rows of the paper's methods that these sets and this encoder do not give."""
    return [
        f"| {name} | – | needs {what}, not measured |{' – |' * 6}" for name, what in NEEDED.items()
    ]


def leads(record: Record) -> list[str]:
    """Return OmniVaT minus each method that was measured as often, by rung."""
    text = [
        f"| OmniVaT minus | {' | '.join(RUNGS.values())} | all seeds averaged |",
        "| --- |" + " ---: |" * 5,
    ]
    tables = {rung: record.cells(rung) for rung in RUNGS}
    for name in complete(record):
        if name == "omnivat":
            continue
        row = [NAMES[name]]
        for cells in tables.values():
            row.append(less(cells["omnivat"], cells[name]))
        several = tables["none"]
        both = "omnivat_mean" in several and f"{name}_mean" in several
        row.append(less(several["omnivat_mean"], several[f"{name}_mean"]) if both else "–")
        text.append(f"| {' | '.join(row)} |")
    return text


def less(ours: Array, theirs: Array) -> str:
    """Return the paired difference with its interval, over the seeds that both have."""
    seeds = min(ours.shape[2], theirs.shape[2])
    mean, low, high = interval(ours[:, :, :seeds] - theirs[:, :, :seeds])
    return f"{mean:+.1f} [{low:.1f}, {high:.1f}]".replace("-", "−")


def apart(record: Record) -> list[str]:
    """Return readings of one image, and look-alikes, as they come, over all seeds."""
    head = [*READINGS.values(), "look-alikes, both", "look-alikes, photo alone"]
    text = [f"| method | {' | '.join(head)} |", "| --- |" + " ---: |" * len(head)]
    tables = [record.cells(rung) for rung in READINGS]
    tables += [record.cells(rung, alike=True) for rung in ("none", "vis")]
    for name in complete(record):
        if all(name in cells for cells in tables):
            means = [np.nanmean(np.nanmean(cells[name], axis=(1, 2))) for cells in tables]
            text.append(f"| {NAMES[name]} | {' | '.join(f'{mean:.1f}' for mean in means)} |")
    return text


def gains(record: Record) -> list[str]:
    """Return what every step of knowledge brings over nothing, in points, for docs/new-
    sensor.md.
    """
    names = [
        name for name in ("omnivat", "linear_maps", "nearest_mean") if name in complete(record)
    ]
    text = [
        f"| known of the target | {' | '.join(NAMES[n] for n in names)} |",
        "| --- |" + " ---: |" * len(names),
    ]
    base = record.cells("none")
    for rung, words in ((row["id"], row["words"]) for row in ROWS):
        cells = record.cells(rung)
        row = []
        for name in names:
            if name not in cells:
                row.append("–")
            elif rung in ("home", "none"):
                row.append(f"{np.nanmean(np.nanmean(cells[name], axis=(1, 2))):.1f} %")
            else:
                row.append(less(cells[name], base[name]))
        if set(row) != {"–"}:
            text.append(f"| {words} | {' | '.join(row)} |")
    return text


def picture(record: Record) -> str:
    """Return the table as a figure: accuracy by what is known, for three methods."""
    rows = []
    for rung, words in RUNGS.items():
        cells = record.cells(rung)
        for name in ("linear_maps", "omnivat", "nearest_mean"):
            mean, low, high = (value / 100 for value in interval(cells[name]))
            told = {"accuracy": mean, "low": low, "high": high, "method": NAMES[name]}
            rows.append({"known": words, **told})
    return svg_of(ladder(rows))


def page(record: Record) -> str:
    """Return docs/benchmarks/table.md."""
    from benchmarks import table

    protocol = (table.__doc__ or "").split("\n\n")
    return "\n".join(
        [
            "# One table of results",
            "",
            (
                "`python -m benchmarks.table --pack` wrote the record"
                " (`examples/records/ladder.jsonl.gz`),"
            ),
            "`python -m benchmarks.table_text` this page and the README's table, and",
            "`python -m benchmarks.recompute` computes the figures again with code of its own.",
            "",
            protocol[2].replace(
                "`RECIPE`", "noise 4, shift 1, 120 epochs, D = 64 where it applies"
            ),
            "",
            *main_table(record),
            *not_measured(),
            "",
            (
                "Accuracy in percent on unseen domains, both images; 95 % intervals draw sources,"
                " targets and seeds. Seconds are the"
            ),
            (
                "median of a training with the choice of its settings, on cores that were shared by"
                " twenty processes. All seeds averaged:"
            ),
            "the mean of the probabilities of all seeds; it has no seed to draw.",
            "",
            *leads(record),
            "",
            "## By relief",
            "",
            (
                "`python -m benchmarks.table --relief --pack` wrote the record"
                " (`examples/records/relief.jsonl.gz`): the"
            ),
            (
                "same pairs, with touches read by how the gel bends"
                " ([relief](../relief.md)). In brackets: points more than by colours"
            ),
            (
                "that know as much of the target, paired, over the seeds of this table. As it"
                " comes, each touch is read by the lamps"
            ),
            "that it gives alone; lamps of 5 or 20 are those of pictures without labels.",
            "",
            *by_relief(record, Record(RELIEF)),
            "",
            *leads_by_relief(Record(RELIEF)),
            "",
            "## What averaging brings",
            "",
            (
                "As it comes. With a profile or labels there is no such row: each seed draws other"
                " known pairs, so the mean would know more of them."
            ),
            "",
            *averaged(record),
            "",
            "## One image, and look-alikes",
            "",
            (
                "Readings of one image alone, and the test pairs that look like another class, as"
                " they come:"
            ),
            "",
            *apart(record),
            "",
        ]
    )


def findings(record: Record) -> list[str]:
    """Return the report's sentences on the table."""
    cells = {rung: record.cells(rung) for rung in ("home", *RUNGS)}

    def told(rung: str, name: str) -> str:
        mean, low, high = interval(cells[rung][name])
        return f"{mean:.1f} % [{low:.1f}, {high:.1f}]"

    def lead(rung: str, which: str = "") -> str:
        return less(cells[rung][f"omnivat{which}"], cells[rung][f"linear_maps{which}"])

    of_chirps = {name: interval(values)[0] for name, values in chirps().items()}
    return [
        (
            "**The sensor.** Linear maps of photo, touch and both, averaged, are right for"
            f" {told('home', 'linear_maps')} of the test pairs at home and"
            f" {told('none', 'linear_maps')} on sensors that they have not met. OmniVaT has"
            f" {told('home', 'omnivat')} and {told('none', 'omnivat')}; its lead over the linear"
            f" maps away is {lead('none')} points, and that of the mean of its heads over the mean"
            f" of theirs {lead('none', '_mean')}."
        ),
        "",
        (
            "**Pictures and labels.** With 5 and 20 pictures of the target without labels the"
            f" linear maps have {told('n5', 'linear_maps')} and {told('n20', 'linear_maps')}, with"
            f" 5 labelled pairs of each class {told('k5', 'linear_maps')}. OmniVaT less these is"
            f" {lead('n5')}, {lead('n20')} and {lead('k5')} points. All rows are in"
            " docs/benchmarks/table.md, made by `python -m benchmarks.table`."
        ),
        "",
        (
            "**Orders.** On chirps, signals that are concentrated at one order, a search finds"
            " that order from the source alone, and a head there is right in"
            f" {of_chirps['omnivat']:.1f} % where p = 0 has {of_chirps['omnivat_p0']:.1f} % and"
            f" linear maps {of_chirps['linear_maps']:.1f} %. On the sensors, heads trained at 21"
            " orders differ no more than seeds do: behind a learned dense map, orders add nothing"
            " to seeds."
        ),
    ]


def between(name: str, made: Sequence[str], marks: tuple[str, str] = MARKS) -> str:
    """Return a document with lines between its markers."""
    text = (ROOT / name).read_text(encoding="utf-8")
    start, end = text.index(marks[0]) + len(marks[0]), text.index(marks[1])
    return text[:start] + "\n" + "\n".join(made) + "\n" + text[end:]


def readme(record: Record) -> str:
    """Return the README with the table between its markers, and its findings."""
    others = ", ".join(NEEDED)
    note = (
        "Not measured, for want of weights or pictures ([why](docs/benchmarks/table.md)):"
        f" {others}."
    )
    text = between("README.md", [*main_table(record, SHOWN), "", note])
    mean = {rung: interval(record.cells(rung)["linear_maps"])[0] for rung in ("none", "n5", "n20")}
    of_chirps = {name: interval(cells)[0] for name, cells in chirps().items()}
    relief = Record(RELIEF)
    lit = {rung: interval(relief.cells(rung)["linear_maps"])[0] for rung in ("none", "l20", "n20")}
    said = {
        r"by relief [\d.]+ % as it comes, [\d.]+ by lamps of 20 pictures, [\d.]+ with their"
        r" profile": (
            "by relief {none:.1f} % as it comes, {l20:.1f} by lamps of 20 pictures, {n20:.1f} with"
            " their profile".format(**lit)
        ),
        r"[\d.]+ % as it comes, [\d.]+ with 5 pictures, [\d.]+ with 20": (
            "{none:.1f} % as it comes, {n5:.1f} with 5 pictures, {n20:.1f} with 20".format(**mean)
        ),
        r"chirps: [\d.]+ % with a search for p, [\d.]+ at p = 0, linear maps [\d.]+": (
            "chirps: {omnivat:.1f} % with a search for p, {omnivat_p0:.1f} at p = 0, linear maps"
            " {linear_maps:.1f}".format(**of_chirps)
        ),
    }
    for pattern, figure in said.items():
        text, count = re.subn(pattern, figure, text)
        if count != 1:
            raise SystemExit(f"README.md has {count} sentences like '{pattern}'; it needs one.")
    return text


def main() -> None:
    """Write both files, or check that they are those of the record."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="exit with 1 if a file differs")
    options = parser.parse_args()
    record = Record()
    made = {
        PAGE: page(record),
        PAGE.with_suffix(".svg"): picture(record),
        ROOT / "README.md": readme(record),
        ROOT / "docs" / "new-sensor.md": between("docs/new-sensor.md", gains(record)),
        ROOT / "docs" / "sensor.md": between("docs/sensor.md", sensor.table(sensor.recorded())),
        ROOT / "docs" / "protocol.md": between("docs/protocol.md", good_for(record)),
        ROOT / "paper" / "paper.md": between("paper/paper.md", findings(record), FINDINGS),
    }
    if options.check:
        sys.exit(any(file.read_text(encoding="utf-8") != text for file, text in made.items()))
    for file, text in made.items():
        write_text(file, text)


if __name__ == "__main__":
    main()
