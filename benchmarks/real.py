"""Which of the project's statements hold on real pairs, and which do not? Writes
docs/benchmarks/real.json.

    python -m omnivat fetch NAME --out DIR/NAME          for each set of SETS
    python -m benchmarks.real --data DIR [--last]

Whole objects are held out, and intervals are a bootstrap over objects. `--last` measures
ObjectFolder Real as well, which is done once, when every choice is made. docs/real.md holds the
expectations, written before.
"""

import argparse
from collections.abc import Iterator, Mapping
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from PIL import Image

from omnivat.data.dots import fill_dots
from omnivat.data.embeddings import Embeddings
from omnivat.data.images import read_image
from omnivat.data.profile import channels_of, moved, profile_of
from omnivat.data.readers import read_pairs
from omnivat.data.store import load_embeddings
from omnivat.encoders.base import DEFAULT_ENCODER
from omnivat.encoders.embed import embed_pairs
from omnivat.head.checkpoint import Head, load_head
from omnivat.head.teach import Lesson, judged
from omnivat.kit.files import write_csv, write_json
from omnivat.kit.tables import load
from omnivat.measure.evaluate import label_map, predicted_probabilities
from omnivat.measure.gaps.centroid import centroid_gap
from omnivat.measure.gaps.mmd import mmd_rbf
from omnivat.study.baselines import BASELINES
from omnivat.study.baselines.contract import Source
from omnivat.study.shift.measure import interval
from omnivat.study.shift.probe import VIEWS, fitted_probe
from omnivat.training import TrainSettings, train
from omnivat.training.from_pairs import plan_training

COMMAND = "python -m benchmarks.real --data DIR"
SETS = ("vt60", "billets", "touch-and-go", "tag-samples", "octopi", "digit-parts")
LAST = "objectfolder-real"
FILLED = "dots-filled"  # touches of Touch and Go without their dots
EXAMPLES = Path("examples")
HEADS = {  # name -> white noise, shift, p fixed at 0
    "OmniVaT": (4.0, 1.0, False),
    "OmniVaT without training noise": (0.0, 0.0, False),
    "OmniVaT without training noise, p = 0": (0.0, 0.0, True),
}
RIVALS = {"ERM-MLP": "erm_mlp", "linear maps": "linear_maps"}
KNOWN, DRAWS, FEW = 20, 100, 7  # there are 7 real touches of TAG
# The parts of Octopi whose material is plain from their names; the authors give none, so the choice
# is ours.
MATERIALS = {
    "plastic": (
        "bubble wrap", "controller base", "controller keypad", "feather duster handle", "hairbrush handle",
        "lanyard card", "pen base", "rice spatula base", "rice spatula handle", "rice spatula head",
        "scissor handle", "strainer handle", "toilet brush handle", "toothbrush handle", "tv remote back",
        "water bottle",
    ),
    "steel": (
        "aluminium foil", "bread knife blade", "scissor blade", "steel wool", "strainer base",
        "strainer head", "tsa lock base",
    ),
    "wood": ("clothes peg", "wood ruler"),
}  # fmt: skip
Array = NDArray[Any]
Raw = dict[str, Array]
Record = dict[str, Any]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, required=True, help="folder with the fetched sets")
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks/real.json"))
    parser.add_argument("--last", action="store_true", help="measure ObjectFolder Real, too")
    options = parser.parse_args()
    real = {name: embedded(options.data, name) for name in (*SETS, FILLED, LAST)}
    records = [
        *home("vt60", real["vt60"]),
        *home("billets", real["billets"]),
        *profiles(real["vt60"]),
    ]
    records += [*distances(real), *dots(options.data)]
    if options.last:
        records += [*one_touch_away(real), *shipped(real[LAST])]
    write_json(options.out, {"command": COMMAND + " --last" * options.last, "records": records})


def embedded(data: Path, name: str) -> Embeddings:
    """Return the embeddings of a fetched set; they are made once, beside its folder."""
    file = data / f"{name}.safetensors"
    if not file.exists():
        embed_pairs(
            read_pairs(without_dots(data) if name == FILLED else data / name), DEFAULT_ENCODER, file
        )
    return load_embeddings(file)


def touches_of(data: Path) -> list[Path]:
    return [pair.tac for pair in read_pairs(data / "touch-and-go").pairs]


def without_dots(data: Path) -> Path:
    """Write the touches of Touch and Go with their dots filled, as a folder of touches; return
    it.
    """
    folder, rows = data / FILLED, []
    folder.mkdir(exist_ok=True)
    for k, file in enumerate(touches_of(data)):
        after, _ = fill_dots(np.asarray(read_image(file)))
        Image.fromarray(after).save(folder / f"{k:03d}_tac.png")
        rows.append([f"{k:03d}_tac.png"] * 2 + ["Touch and Go, dots filled", "touch"])
    write_csv(folder / "pairs.csv", ("vis", "tac", "domain", "material"), rows)
    return folder


def raw(data: Embeddings, rows: Array) -> Raw:
    return {name: np.array(getattr(data, name)[rows], np.float32) for name in ("vis", "tac")}


def line(part: str, what: str, right: Array, objects: Array, **more: Any) -> Record:
    """Return the mean of N values, such as 1 for a right prediction, with its interval over
    objects.
    """
    low, high = interval(right.astype(float), objects)
    count = {"n": len(right), "objects": len(np.unique(objects))}
    record = {
        "part": part,
        "what": what,
        "value": float(right.mean()),
        "low": low,
        "high": high,
        **count,
        **more,
    }
    print(
        f"{part:10} {what:60} {100 * record['value']:6.1f} [{100 * low:.1f}, {100 * high:.1f}]  n"
        f" {len(right)}",
        flush=True,
    )
    return record


def home(name: str, data: Embeddings) -> Iterator[Record]:
    """Yield what each method predicts for objects that it did not see: two halves of the
    objects, both ways.
    """
    objects = np.array(data.rows["object"])
    order = {thing: k for k, thing in enumerate(sorted(set(objects)))}
    half = np.array([order[thing] % 2 for thing in objects])
    right: dict[str, Array] = {}
    for fold in (0, 1):
        fit, test = np.flatnonzero(half != fold), np.flatnonzero(half == fold)
        for method, predicted in answers(data, fit, test).items():
            right.setdefault(method, np.zeros(len(objects)))[test] = predicted == data.label[test]
    largest = np.bincount(data.label).max() / len(data)
    for method, values in right.items():
        yield line(name, method, values, objects, chance=float(largest))
    maps = "linear maps"
    pairs = {
        "two images less the photo, linear maps": (maps, f"{maps}, vis"),
        "two images less the touch, linear maps": (maps, f"{maps}, tac"),
        "two images less the photo, OmniVaT": ("OmniVaT", "OmniVaT, vis"),
        "OmniVaT less linear maps": ("OmniVaT", maps),
        "OmniVaT without training noise less linear maps": ("OmniVaT without training noise", maps),
        "OmniVaT without training noise less ERM-MLP": (
            "OmniVaT without training noise",
            "ERM-MLP",
        ),
        "learned p less p = 0": tuple(HEADS)[1:3],
    }
    for what, (one, other) in pairs.items():
        yield line(name, what, right[one] - right[other], objects, difference=True)


def answers(data: Embeddings, fit: Array, test: Array) -> dict[str, Array]:
    """Return the predicted labels of `test` by each method that learned `fit`."""
    found = {}
    known, shown = raw(data, fit), raw(data, test)
    tensors = {name: torch.from_numpy(rows) for name, rows in shown.items()}
    source = Source(
        vis=torch.from_numpy(known["vis"]),
        tac=torch.from_numpy(known["tac"]),
        labels=torch.from_numpy(data.label[fit].astype(np.int64)),
        objects=tuple(data.rows["object"][k] for k in fit),
        classes=tuple(data.header.classes),
        settled=("none",),  # no training noise for linear maps: one sensor, at home
    )
    for name, method in RIVALS.items():
        shares = load(BASELINES, method, kind="method")(source).predict(
            tensors["vis"], tensors["tac"]
        )
        for reading, values in shares.items():
            found[name if reading == "fused" else f"{name}, {reading}"] = values.argmax(-1).numpy()
    for name, (noise, shift, fixed) in HEADS.items():
        order = {"order": 0.0, "learn_order": False} if fixed else {}
        settings = TrainSettings(epochs=40, batch=64, noise=noise, shift=shift, lang=False)
        plan = plan_training(
            data.select(fit), data.header.domains[0], head={"width": 64, **order}, training=settings
        )
        model = train(plan.pairs, plan.settings, plan.training, bank=plan.bank, seed=0).model
        back = label_map(data.header.classes, model.settings.classes)
        for view, modalities in VIEWS.items():
            shares = predicted_probabilities(model, data, modalities=modalities, rows=test)
            found[name if view == "both" else f"{name}, {view}"] = back[
                shares["fused"].argmax(-1).numpy()
            ]
    return found


def profiles(data: Embeddings) -> Iterator[Record]:
    """Yield what a profile of 20 pictures of the same sensor brings the linear maps."""
    objects = np.array(data.rows["object"])
    order = {thing: k for k, thing in enumerate(sorted(set(objects)))}
    half, random = np.array([order[thing] % 2 for thing in objects]), np.random.default_rng(0)
    gain = np.zeros(len(objects))
    kept = np.ones(len(objects), bool)
    for fold in (0, 1):
        fit, test = np.flatnonzero(half != fold), np.flatnonzero(half == fold)
        pictures = random.permutation(test)[:KNOWN]
        kept[pictures] = False
        source, shown, few = raw(data, fit), raw(data, test), raw(data, pictures)
        fitted = fitted_probe(source, data.label[fit])
        near = {
            name: moved(rows, channels_of(few[name]), channels_of(source[name]))
            for name, rows in shown.items()
        }
        plain, known = (fitted(rows)["both"] == data.label[test] for rows in (shown, near))
        gain[test] = known.astype(float) - plain
    yield line(
        "vt60",
        f"profile of {KNOWN} pictures less none, linear maps",
        gain[kept],
        objects[kept],
        difference=True,
    )


def distances(real: Mapping[str, Embeddings]) -> Iterator[Record]:
    """Yield gaps between domains, each the mean of 100 draws of 7 pictures of both, photos and
    touches apart.
    """
    simulated = load_embeddings(EXAMPLES / "simulated.safetensors")
    names = {
        "TAG, real": real["touch-and-go"],
        "TAG, real, dots filled": real[FILLED],
        "TAG, grey samples": real["tag-samples"],
        "Octopi": real["octopi"],
        "DIGIT parts": real["digit-parts"],
        "Billets": real["billets"],
        "VT60": real["vt60"],
        "OF Real, real": real[LAST],
    }
    alone = {"TAG, real, dots filled", "Octopi", "DIGIT parts"}
    for half in ("vis", "tac"):
        rows = {
            domain: np.array(getattr(simulated, half)[simulated.domain == k], np.float32)
            for k, domain in enumerate(simulated.header.domains)
        }
        rows |= {
            name: np.array(getattr(own, half), np.float32)
            for name, own in names.items()
            if half == "tac" or name not in alone
        }
        same = ((name, name) for name, own in rows.items() if len(own) >= 2 * FEW)
        for first, second in [*combinations(rows, 2), *same]:
            yield distance(half, first, second, rows)


def distance(half: str, first: str, second: str, rows: Mapping[str, Array]) -> Record:
    random = np.random.default_rng(0)
    gaps: dict[str, list[float]] = {"centroid": [], "mmd_rbf": []}
    for _ in range(DRAWS):
        a = random.permutation(len(rows[first]))
        b = a[len(a) // 2 :] if first == second else random.permutation(len(rows[second]))
        one, other = (torch.from_numpy(rows[n][own[:FEW]]) for n, own in ((first, a), (second, b)))
        gaps["centroid"].append(centroid_gap(one, other).item())
        gaps["mmd_rbf"].append(mmd_rbf(one, other).item())
    values = {name: float(np.mean(found)) for name, found in gaps.items()}
    spread = {f"{name}_sd": float(np.std(found)) for name, found in gaps.items()}
    return {
        "part": "distance",
        "modality": half,
        "from": first,
        "to": second,
        "n": FEW,
        **values,
        **spread,
    }


def dots(data: Path) -> Iterator[Record]:
    """Yield in how many real touches a grid of dots is found, with markers and without."""
    counts = {"printed dots (Touch and Go)": touches_of(data)}
    for name in ("tag-samples", "billets", LAST, "octopi", "digit-parts"):
        counts[f"no dots ({name})"] = [pair.tac for pair in read_pairs(data / name).pairs][:40]
    for what, files in counts.items():
        found = np.array([fill_dots(np.asarray(read_image(file)))[1] is not None for file in files])
        yield line("dots", f"a grid of dots is found: {what}", found, np.arange(len(found)))


def weighed(right: Array, labels: Array) -> Array:
    """Return values whose mean is the mean accuracy over classes."""
    counts = np.bincount(labels, minlength=labels.max() + 1)
    return np.asarray(right / counts[labels] * len(labels) / (counts > 0).sum())


def one_touch_away(real: Mapping[str, Embeddings]) -> Iterator[Record]:
    """Yield how well three materials are told from one real touch, at home and by another real
    sensor.
    """
    octopi, there = real["octopi"], real[LAST]
    material = {part: name for name, parts in MATERIALS.items() for part in parts}
    classes = tuple(MATERIALS)
    sets = []
    for data, names in (
        (octopi, [material.get(data_class, "") for data_class in octopi.header.classes]),
        (there, list(there.header.classes)),
    ):
        rows = np.flatnonzero([names[k] in classes for k in data.label])
        label = np.array([classes.index(names[data.label[k]]) for k in rows])
        things = (
            [data.header.classes[k] for k in data.label] if data is octopi else data.rows["object"]
        )
        sets.append(({"tac": raw(data, rows)["tac"]}, label, np.array(things)[rows]))
    for name, (shown, label, parts) in zip(("Octopi", "OF Real"), sets, strict=True):
        right = np.zeros(len(label))
        for thing in sorted(set(parts)):
            out = parts == thing
            fitted = fitted_probe({"tac": shown["tac"][~out]}, label[~out])
            right[out] = fitted({"tac": shown["tac"][out]})["tac"] == label[out]
        yield line(
            "touch",
            f"three materials at home, each object left out: {name}",
            weighed(right, label),
            parts,
        )
    for (first, one), (second, two) in (
        (("Octopi", sets[0]), ("OF Real", sets[1])),
        (("OF Real", sets[1]), ("Octopi", sets[0])),
    ):
        fitted = fitted_probe(one[0], one[1])
        near = {"tac": moved(two[0]["tac"], channels_of(two[0]["tac"]), channels_of(one[0]["tac"]))}
        for how, felt in (("as they come", two[0]), ("with its whole profile", near)):
            right = fitted(felt)["tac"] == two[1]
            yield line(
                "touch",
                f"three materials, {first} to {second}, {how}",
                weighed(right, two[1]),
                two[2],
            )


def shipped(data: Embeddings) -> Iterator[Record]:
    """Yield what heads of the simulated TAG make of ObjectFolder Real: as it comes, with its
    profile, and taught.
    """
    head, simulated = (
        load_head(EXAMPLES / "head"),
        load_embeddings(EXAMPLES / "simulated.safetensors"),
    )
    objects, truth = (
        np.array(data.rows["object"]),
        label_map(head.settings.classes, data.header.classes)[data.label],
    )
    chance = {"chance": float(np.bincount(truth).max() / len(truth))}
    near = head.profiled(data, [profile_of(data, domain=data.header.domains[0])])
    for how, some in (("as they come", data), ("with its whole profile", near)):
        for view, modalities in VIEWS.items():
            shares = predicted_probabilities(head.model, some, modalities=modalities)["fused"]
            what = f"shipped head (TAG-sim), {view}, {how}"
            yield line("of-real", what, shares.argmax(-1).numpy() == truth, objects, **chance)
    classes = label_map(simulated.header.classes, data.header.classes)[data.label]
    for domain in ("TAG-sim", "OF Real-sim"):
        rows = np.flatnonzero(simulated.domain == simulated.header.domains.index(domain))
        source, shown = raw(simulated, rows), raw(data, np.arange(len(data)))
        fitted = fitted_probe(source, simulated.label[rows])
        moved_rows = {
            n: moved(own, channels_of(own), channels_of(source[n])) for n, own in shown.items()
        }
        for how, own in (("as they come", shown), ("with its whole profile", moved_rows)):
            for view, found in fitted(own).items():
                yield line(
                    "of-real",
                    f"linear maps of {domain}, {view}, {how}",
                    found == classes,
                    objects,
                    **chance,
                )
    yield from taught_lines(head, data, objects, chance)


def taught_lines(
    head: Head, data: Embeddings, objects: Array, chance: Mapping[str, float]
) -> Iterator[Record]:
    rows = raw(data, np.arange(len(data)))
    lessons = [
        Lesson(
            label=data.header.classes[data.label[k]],
            vis=torch.from_numpy(rows["vis"][k : k + 1]),
            tac=torch.from_numpy(rows["tac"][k : k + 1]),
            object=str(objects[k]),
        )
        for k in range(len(data))
    ]
    report = judged(head, lessons)
    right = np.array([one.after == one.label for one in report.judged])
    yield line("of-real", "taught by the other objects", right, objects, **chance)


if __name__ == "__main__":
    main()
