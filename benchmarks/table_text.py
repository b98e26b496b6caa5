"""The table of results from its record: docs/benchmarks/table.md and .svg, the README between its
markers.

    python -m benchmarks.table_text [--check]

It also writes the tables of docs/new-sensor.md, docs/protocol.md and docs/sensor.md, the first
finding of the README and the findings of the report. docs/benchmarks/chirps.jsonl.gz is
`runs.jsonl` of

    python -m omnivat protocol --embeddings examples/chirps/chirps.safetensors --out DIR \\
        --methods omnivat,omnivat_p0,linear_maps,erm_mlp,nearest_mean --seeds 0,1,2 \\
        --set width=64 --set theta_init=signed --set lang=false --set epochs=40 \\
        --set order_search=true
"""

import argparse
import re
import sys
from collections.abc import Iterable

from benchmarks import sensor
from benchmarks._markdown import table
from benchmarks._table_record import (
    BOTH,
    RECORDS,
    ROOT,
    THREE,
    WIDE,
    Array,
    Cells,
    Record,
    chirps,
    interval,
    less,
    mean_of,
    real,
    signed,
    twins,
    with_interval,
)
from omnivat.figures.scores import ladder
from omnivat.figures.still import svg_of
from omnivat.head.heads import RELIEF
from omnivat.kit.files import write_text
from omnivat.measure.rungs import RUNGS as ROWS

PAGE = RECORDS / "table.md"
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
INPUTS = {
    THREE: "Linear maps of photo, colours, relief and all three",
    WIDE: "Linear maps of photo, touch as one vector of colours and relief, and both",
}
OURS, THEIRS, MEAN = "omnivat", "linear_maps", "nearest_mean"
SHOWN = ("erm_mlp", THEIRS, OURS, MEAN, "baseline")  # rows of the README
HOME = "OmniVaT without training noise"  # the better of both on real pairs
FEW = (10, 20)  # training pairs of each class


def by_relief(record: Record, relief: Record) -> str:
    """Return readings by relief, and in brackets their gain over colours that know as much."""
    lit = {rung: relief.cells(rung) for rung in LIT}
    plain = {rung: record.cells(rung) for _, rung in LIT.values()}

    def cell(name: str, rung: str) -> str:
        if name not in lit[rung]:
            return "–"
        gain = less(lit[rung][name], plain[LIT[rung][1]][name])
        return f"{mean_of(lit[rung][name]):.1f} ({gain})"

    alone = {name: cells for name, cells in lit["n20"].items() if name in NAMES}
    methods = sorted(alone.items(), key=lambda row: -mean_of(row[1]))
    return table(
        ["method", "seeds", *(words for words, _ in LIT.values())],
        [[NAMES[m], str(x.shape[2]), *(cell(m, rung) for rung in LIT)] for m, x in methods],
    )


def leads_by_relief(relief: Record) -> str:
    """Return OmniVaT minus each other method, both by relief."""
    rungs = {rung: words for rung, (words, _) in LIT.items() if "," not in words}
    lit = [relief.cells(rung) for rung in rungs]
    return table(
        ["OmniVaT minus", *rungs.values()],
        [
            [NAMES[name], *(less(cells[OURS], cells[name]) for cells in lit)]
            for name in relief.cells("n20")
            if name in NAMES and name != OURS
        ],
    )


def with_colours(relief: Record) -> str:
    """Return what reads relief and colours, and in brackets its gain over relief alone."""
    lit = [relief.cells(rung) for rung in LIT]
    rows = [[words, n + BOTH, n] for n, words in NAMES.items() if n + BOTH in lit[0]]
    rows = [[words, name, THEIRS] for name, words in INPUTS.items()] + rows

    def cell(cells: Cells, both: str, alone: str) -> str:
        if both not in cells:
            return "–"
        return f"{mean_of(cells[both]):.1f} ({less(cells[both], cells[alone])})"

    return table(
        ["relief and colours", *(words for words, _ in LIT.values())],
        [[words, *(cell(cells, *names) for cells in lit)] for words, *names in rows],
    )


def main_table(record: Record, only: Iterable[str] = NAMES) -> str:
    """Return the table of results: methods by rungs, one head and the mean of several."""
    tables, rows = [record.cells(rung) for rung in RUNGS], []
    for name in record.complete(NAMES):
        if name in only:
            seeds, *costs = record.costs(name)
            several = tables[0].get(f"{name}_mean")
            mean = "–" if several is None else with_interval(several)
            cells = [with_interval(own[name]) for own in tables]
            rows.append([NAMES[name], seeds, *cells, mean, *costs])
    head = ["method", "seeds", *RUNGS.values(), "all seeds averaged, as it comes"]
    return table([*head, "seconds", "numbers"], rows)


def averaged(record: Record) -> str:
    """Return the mean of all heads of a method as it comes, beside one head.

    Each seed draws other known pairs, so a mean of heads with a profile would know more of them.
    """
    cells, rows = record.cells("none"), []
    heads = {r["method"]: r["heads"] for r in record.runs}
    for name in record.complete(NAMES):
        if (several := f"{name}_mean") in heads:
            gain = less(cells[several], cells[name].mean(axis=2, keepdims=True))
            figures = [with_interval(cells[name]), with_interval(cells[several]), gain]
            rows.append([NAMES[name], str(heads[several]), *figures])
    return table(["method", "heads", "one head", "their mean", "gain"], rows)


def good_for(record: Record) -> str:
    """Return where OmniVaT was compared with the linear maps, a row each."""
    none, vis, tac = (record.cells(rung) for rung in ("none", "vis", "tac"))
    alike, signals, of_twins = record.cells("none", alike=True), chirps(), twins()
    compared = {
        "chirps, p searched": (signals[OURS], signals[THEIRS]),
        "chirps, p = 0": (signals["omnivat_p0"], signals[THEIRS]),
        "twins: the sensor alone changed, by touch": (of_twins[OURS], of_twins[THEIRS]),
        **{f"{n} pairs of each class": (none[f"{OURS}@{n}"], none[f"{THEIRS}@{n}"]) for n in FEW},
        "all pairs, 40 of each class": (none[OURS], none[THEIRS]),
        "touch missing": (vis[OURS], vis[THEIRS]),
        "photo missing": (tac[OURS], tac[THEIRS]),
        "look-alikes": (alike[OURS], alike[THEIRS]),
        "all seeds averaged": (none[f"{OURS}_mean"], none[f"{THEIRS}_mean"]),
    }
    rows = [
        [where, f"{mean_of(a):.1f}", f"{mean_of(b):.1f}", less(a, b)]
        for where, (a, b) in compared.items()
    ]
    pairs = real()
    means = [f"{100 * pairs[name]['value']:.1f}" for name in (HOME, "linear maps")]
    lead = signed(*(100 * pairs[f"{HOME} less linear maps"][k] for k in ("value", "low", "high")))
    rows.append(["real pairs, VT60, objects held out", *means, lead])
    return table(["where", "OmniVaT", "linear maps", "OmniVaT minus linear maps"], rows)


def leads(record: Record) -> str:
    """Return OmniVaT minus each method that was measured as often, by rung."""
    tables = [record.cells(rung) for rung in RUNGS]
    rows = []
    for name in record.complete(NAMES):
        if name != OURS:
            mean = tables[0].get(f"{name}_mean")
            joint = "–" if mean is None else less(tables[0][f"{OURS}_mean"], mean)
            rows.append([NAMES[name], *(less(x[OURS], x[name]) for x in tables), joint])
    return table(["OmniVaT minus", *RUNGS.values(), "all seeds averaged"], rows)


def apart(record: Record) -> str:
    """Return readings of one image, and look-alikes, as they come, over all seeds."""
    tables = [record.cells(rung) for rung in READINGS]
    tables += [record.cells(rung, alike=True) for rung in ("none", "vis")]
    return table(
        ["method", *READINGS.values(), "look-alikes, both", "look-alikes, photo alone"],
        [
            [NAMES[name], *(f"{mean_of(cells[name]):.1f}" for cells in tables)]
            for name in record.complete(NAMES)
            if all(name in cells for cells in tables)
        ],
    )


def gains(record: Record) -> str:
    """Return what every step of knowledge brings over nothing, in points: docs/new-sensor.md."""
    names = [name for name in (OURS, THEIRS, MEAN) if name in record.complete(NAMES)]
    base = record.cells("none")

    def cell(rung: str, own: Array | None, plain: Array) -> str:
        if own is None:
            return "–"
        return f"{mean_of(own):.1f} %" if rung in ("home", "none") else less(own, plain)

    rows = []
    for rung, words in ((row["id"], row["words"]) for row in ROWS):
        cells = record.cells(rung)
        row = [cell(rung, cells.get(name), base[name]) for name in names]
        if set(row) != {"–"}:
            rows.append([words, *row])
    return table(["known of the target", *(NAMES[name] for name in names)], rows)


def picture(record: Record) -> str:
    """Return the table as a figure: accuracy by what is known, for three methods."""
    rows = []
    for rung, words in RUNGS.items():
        cells = record.cells(rung)
        for name in (THEIRS, OURS, MEAN):
            mean, low, high = (value / 100 for value in interval(cells[name]))
            own = {"accuracy": mean, "low": low, "high": high, "method": NAMES[name]}
            rows.append({"known": words, **own})
    return svg_of(ladder(rows))


def page(record: Record) -> str:
    """Return docs/benchmarks/table.md."""
    from benchmarks.table import __doc__ as protocol

    relief, recipe = Record(RELIEF), "noise 4, shift 1, 120 epochs, D = 64 where it applies"
    rules = (protocol or "").split("\n\n")[2].replace("`RECIPE`", recipe)
    missing = (f"| {name} | – | needs {what}, not measured |" for name, what in NEEDED.items())
    none = "\n".join(row + " – |" * 6 for row in missing)
    return f"""# One table of results

`python -m benchmarks.table --pack` wrote the record (`examples/records/ladder.jsonl.gz`),
`python -m benchmarks.table_text` this page and the README's table, and
`python -m benchmarks.recompute` computes the figures again with code of its own.

{rules}

{main_table(record)}
{none}

Accuracy in percent on unseen domains, both images; 95 % intervals draw sources, targets and seeds. Seconds are the
median of a training with the choice of its settings, on cores that were shared by twenty processes. All seeds averaged:
the mean of the probabilities of all seeds; it has no seed to draw.

{leads(record)}

## By relief

`python -m benchmarks.table --relief --pack` wrote the record (`examples/records/relief.jsonl.gz`): the
same pairs, with touches read by how the gel bends ([relief](../relief.md)). In brackets: points more than by colours
that know as much of the target, paired, over the seeds of this table. As it comes, each touch is read by the lamps
that it gives alone; lamps of 5 or 20 are those of pictures without labels.

{by_relief(record, relief)}

{leads_by_relief(relief)}

Relief and colours together: linear maps of three inputs (`--methods three_maps`), of the one vector of `embed --touch both`
(`--methods wide_maps`), and two heads of one method and seed with the mean of their log-probabilities (`--methods
linear_maps+colours`). Three seeds; in brackets, points more than by relief alone:

{with_colours(relief)}

## What averaging brings

As it comes. With a profile or labels there is no such row: each seed draws other known pairs, so the mean would know more of them.

{averaged(record)}

## One image, and look-alikes

Readings of one image alone, and the test pairs that look like another class, as they come:

{apart(record)}
"""  # noqa: E501


def findings(record: Record) -> str:
    """Return the report's sentences on the table."""
    cells = {rung: record.cells(rung) for rung in ("home", *RUNGS)}
    maps = {rung: with_interval(own[THEIRS], " %") for rung, own in cells.items()}
    ours = {rung: with_interval(own[OURS], " %") for rung, own in cells.items()}
    lead = {rung: less(own[OURS], own[THEIRS]) for rung, own in cells.items()}
    joint = less(cells["none"][f"{OURS}_mean"], cells["none"][f"{THEIRS}_mean"])
    signals = {name: f"{mean_of(values):.1f} %" for name, values in chirps().items()}
    return (
        "**The sensor.** Linear maps of photo, touch and both, averaged, are right for"
        f" {maps['home']} of the test pairs at home and {maps['none']} on sensors that they have"
        f" not met. OmniVaT has {ours['home']} and {ours['none']}; its lead over the linear maps"
        f" away is {lead['none']} points, and that of the mean of its heads over the mean of"
        f" theirs {joint}.\n\n"
        "**Pictures and labels.** With 5 and 20 pictures of the target without labels the linear"
        f" maps have {maps['n5']} and {maps['n20']}, with 5 labelled pairs of each class"
        f" {maps['k5']}. OmniVaT less these is {lead['n5']}, {lead['n20']} and {lead['k5']}"
        " points. All rows are in docs/benchmarks/table.md, made by `python -m"
        " benchmarks.table`.\n\n"
        "**Orders.** On chirps, signals that are concentrated at one order, a search finds that"
        f" order from the source alone, and a head there is right in {signals[OURS]} where p = 0"
        f" has {signals['omnivat_p0']} and linear maps {signals[THEIRS]}. On the sensors, heads"
        " trained at 21 orders differ no more than seeds do: behind a learned dense map, orders"
        " add nothing to seeds."
    )


def between(name: str, made: str, marks: tuple[str, str] = MARKS) -> str:
    """Return a document with a text between its markers."""
    text = (ROOT / name).read_text(encoding="utf-8")
    start, end = text.index(marks[0]) + len(marks[0]), text.index(marks[1])
    return f"{text[:start]}\n{made}\n{text[end:]}"


def readme(record: Record) -> str:
    """Return the README with the table between its markers, and its findings."""
    note = (
        "Not measured, for want of weights or pictures ([why](docs/benchmarks/table.md)):"
        f" {', '.join(NEEDED)}."
    )
    text = between("README.md", f"{main_table(record, SHOWN)}\n\n{note}")
    relief = Record(RELIEF)
    found = [
        *(relief.cells(rung)[THEIRS] for rung in ("none", "l20", "n20")),
        relief.cells("n20")[THREE],
        *(record.cells(rung)[THEIRS] for rung in ("none", "n5", "n20")),
        *(chirps()[name] for name in (OURS, "omnivat_p0", THEIRS)),
    ]
    figures = iter([f"{mean_of(cells):.1f}" for cells in found])
    for sentence in (
        "by relief # % as it comes, # by lamps of 20 pictures, # with their profile, # with colours"
        " beside",
        "# % as it comes, # with 5 pictures, # with 20",
        "chirps: # % with a search for p, # at p = 0, linear maps #",
    ):
        wanted = re.sub("#", lambda _: next(figures), sentence)
        text, count = re.subn(sentence.replace("#", r"[\d.]+"), wanted, text)
        if count != 1:
            raise SystemExit(f"README.md has {count} sentences like '{sentence}'; it needs one.")
    return text


def main() -> None:
    """Write the documents, or check that they are those of the record."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="exit with 1 if a file differs")
    options = parser.parse_args()
    record = Record()
    made = {PAGE: page(record), PAGE.with_suffix(".svg"): picture(record)}
    made[ROOT / "README.md"] = readme(record)
    for name, text, marks in (
        ("docs/new-sensor.md", gains(record), MARKS),
        ("docs/sensor.md", sensor.report(sensor.recorded()), MARKS),
        ("docs/protocol.md", good_for(record), MARKS),
        ("paper/paper.md", findings(record), FINDINGS),
    ):
        made[ROOT / name] = between(name, text, marks)
    if options.check:
        sys.exit(any(file.read_text(encoding="utf-8") != text for file, text in made.items()))
    for file, text in made.items():
        write_text(file, text)


if __name__ == "__main__":
    main()
