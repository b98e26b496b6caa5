"""One press by every sensor, as the page draws it: `python -m benchmarks.twins`.

    --pack FOLDER   examples/twins.npz: the twins, embedded with the dots kept and filled
    --page FOLDER   examples/twins.json, twins.map.json and twins/, for the page

FOLDER is what `python -m simulator twins` drew; of an interrupted drawing, objects count as
photographed that have all photographs. `--learn KEPT FILLED` are the embeddings that heads learn
from: the simulated domains, with the dots kept and filled; those by relief are in examples/relief.
The head is logistic regression on standardised unit rows, learned from the training pairs of one
domain. The split of a loss into its parts is that of docs/benchmarks/twins.json.
"""

import argparse
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image

from benchmarks._twins_heads import (
    FILLED,
    KEPT,
    LIT,
    PARTS,
    PICTURES,
    READINGS,
    RELIEF,
    Array,
    Seen,
    everything,
    pools,
    share,
)
from benchmarks._twins_maps import threads
from benchmarks.relief import Reliefs
from omnivat.data.domains import paper_name
from omnivat.data.dots import fill_dots
from omnivat.data.embeddings import Embeddings
from omnivat.data.materials import MATERIALS
from omnivat.data.relief import NoLampsError, drawn, lamps
from omnivat.data.store import load_embeddings
from omnivat.encoders import load_encoder
from omnivat.head.heads import EXAMPLES
from omnivat.kit.files import replacing, write_text
from omnivat.kit.threads import one_thread
from omnivat.measure.twins import Twins, twins, write_twins
from simulator.build import image_path
from simulator.domains import SIMULATED, SimulatedDomain
from simulator.plan import Planned
from simulator.sensors import SENSORS, Sensor, TaximSensor
from simulator.twins import twin, unmet_objects

RECORD = Path("docs/benchmarks/twins.json")
TILE, PRESS, QUALITY = 144, 56, 80  # pixels of a picture, of a small one; of WebP


def embedded(encoder: Any, images: Sequence[Array]) -> Array:
    """Return embeddings (n, W) of images (H, W, 3), 25 at a time."""
    parts = [
        encoder.embed(
            torch.stack(
                [encoder.preprocess(Image.fromarray(image)) for image in images[k : k + 25]]
            )
        )
        for k in range(0, len(images), 25)
    ]
    rows: Array = torch.cat(parts).numpy()
    return rows


def by_relief(pictures: Sequence[Array], count: int, classes: int, encoder: Any) -> Array:
    """Return embeddings (LIT, PARTS, count, W) of the first touches of a sensor by relief.

    pictures  touches (H, W, 3), their dots filled; LIT of them give lamps

    Each third, and its pool, is read by the lamps of the pool, and where it gives none, or with no
    picture, by each touch's own.
    """
    found = np.full((len(LIT), PARTS, count, encoder.width), np.nan, np.float32)
    alone = embedded(encoder, [drawn(touch, dots="keep") for touch in pictures[:count]])
    for r, number in enumerate(LIT):
        for k, (part, pool) in enumerate(pools(count, number, classes, seed=0)):
            read = np.union1d(part, pool)
            try:
                by = lamps((pictures[i] for i in pool), dots="keep")
            except NoLampsError:
                found[r, k, read] = alone[read]
            else:
                images = [drawn(pictures[i], by, dots="keep") for i in read]
                found[r, k, read] = embedded(encoder, images)
    return found


def reliefs(folder: Path, photographed: int) -> dict[str, list[Array]]:
    """Return "touch", "both" -> `by_relief` of the touches of each sensor; both are fewer."""
    encoder, classes = load_encoder("efficientnet-lite0"), len(MATERIALS)
    found: dict[str, list[Array]] = {"touch": [], "both": []}
    for domain in SIMULATED.values():
        touches = [fill_dots(picture(folder, unmet, domain))[0] for unmet in unmet_objects()]
        for reading, count in (("touch", len(touches)), ("both", photographed)):
            found[reading].append(by_relief(touches, count, classes, encoder))
    return found


def picture(folder: Path, unmet: Planned, domain: SimulatedDomain, kind: str = "tac") -> Array:
    """Return an image (H, W, 3) uint8 of an object in a domain."""
    return np.asarray(Image.open(image_path(folder, twin(unmet, domain), kind)).convert("RGB"))


def shown(made: Twins, first: Seen, filled: Seen, each: int = 4) -> list[int]:
    """Return `each` objects of every class, by what the first source's head reads by touch: those
    that the fill turns right on most sensors, and one that stays wrong on most of them.
    """
    count = len(made.vis)  # only these have photographs
    turned = (first.right[0, 0] * (filled.right[0] - first.right[0])[1:].sum(0))[:count]
    stays = filled.right[-1, 1:, :count].sum(0)
    chosen = []
    for label in range(len(made.header.classes)):
        own = np.flatnonzero(made.label[:count] == label)
        best = own[np.argsort(-turned[own], kind="stable")]
        wrong = own[np.argsort(stays[own], kind="stable")][0]
        chosen += [*[int(n) for n in best if n != wrong][: each - 1], int(wrong)]
    return chosen


def page(
    made: Twins,
    learning: Sequence[Embeddings],
    relief: Mapping[str, Sequence[Array]],
    about: Sequence[Mapping[str, str]],
) -> tuple[dict[str, Any], list[int]]:
    """Return the contents of `examples/twins.json`, and the numbers of the objects that it shows.

    The keys, in the order of the domains of the twins (S), of `pictures` after none (R), and of the
    shown objects:

    domains     name, sensor, scene and one sentence about the sensor
    known       reading -> how many pictures each of `pictures` stands for: fewer where the twins
                have no more
    lamps       how many of them a reading by relief takes at most
    learned     by source: indices of the classes that its head knows
    presses     reading -> by source: how many twins of these classes were tested
    accuracy    reading -> [source][look][R][target] -> [share, low, high] over these presses, 95 %
                over objects; look 0: dots as printed, 1: filled, 2: touch by relief, in training
                and test; photos have the first only
    away        reading -> [source][look][R] -> the same, for the mean of the other seven domains
    verdicts    reading -> [source][look][R] -> a digit for each shown object and target: the
                predicted class
    shown       class, name, press (its number among the twins), looks_like, feels_like, sheet (its
                pictures)
    """
    heads = everything(made, learning, relief)
    objects = shown(made, heads["touch", 0, KEPT], heads["touch", 0, FILLED])
    classes, sources = made.header.classes, range(len(made.header.domains))
    known = [
        np.unique(learning[0].in_domain(name, split="train").label) for name in made.header.domains
    ]
    tested = [np.isin(made.label, some) for some in known]

    def table(cell: Any) -> dict[str, Any]:
        return {
            reading: [
                [
                    [cell(heads[reading, s, look], s, r) for r in range(1 + len(PICTURES))]
                    for look in ((KEPT,) if reading == "photo" else (KEPT, FILLED, RELIEF))
                ]
                for s in sources
            ]
            for reading in READINGS
        }

    def away(seen: Seen, source: int, r: int) -> list[float]:
        others = [target for target in sources if target != source]
        return share(seen.right[r, others].mean(0)[tested[source][: seen.count]])

    return {
        "simulated": True,
        "made_by": "python -m benchmarks.twins --page",
        "head": (
            "logistic regression on EfficientNet-Lite0 features, learned from the training pairs of"
            " {source}"
        ),
        "classes": list(classes),
        "domains": list(about),
        "objects": len(made.label),
        "pictures": list(PICTURES),
        "known": {
            reading: [min(n, heads[reading, 0, 0].count * (PARTS - 1) // PARTS) for n in PICTURES]
            for reading in READINGS
        },
        "lamps": LIT[-1],
        "learned": [some.tolist() for some in known],
        "presses": {
            reading: [int(tested[s][: heads[reading, s, 0].count].sum()) for s in sources]
            for reading in READINGS
        },
        "accuracy": table(
            lambda seen, s, r: [share(seen.right[r, t][tested[s][: seen.count]]) for t in sources]
        ),
        "away": table(away),
        "shown": [
            {
                "class": int(made.label[n]),
                "name": made.objects[n].split("/")[-1].replace("-", " "),
                "press": n,
                "looks_like": made.looks_like[n],
                "feels_like": made.feels_like[n],
                "sheet": f"{k:02d}.webp",
            }
            for k, n in enumerate(objects)
        ],
        "verdicts": table(lambda seen, s, r: "".join(map(str, seen.said[r][:, objects].T.ravel()))),
    }, objects


def sheets(made: Twins, objects: Sequence[int], pictures: Path, folder: Path) -> None:
    """Write the pictures of the shown objects: a sheet for each, and a row of their first touches.

    pictures  the folder that `python -m simulator twins` wrote
    A sheet has a column for each domain, and three rows: photograph, touch, touch with the dots
    filled. The relief of each touch by itself, in grey, has a sheet of its own, of one row.
    """
    row = Image.new("RGB", (PRESS * len(objects), PRESS))
    for k, n in enumerate(objects):
        stem = made.objects[n].split("/")[-1]
        sheet = Image.new("RGB", (TILE * len(made.header.domains), TILE * 3))
        relief = Image.new("L", (sheet.width, TILE))
        for column, domain in enumerate(made.header.domains):
            place = pictures / domain / stem.split("-")[0]
            touch = Image.open(place / f"{stem}_tac.png").convert("RGB")
            clean = fill_dots(np.asarray(touch))[0]
            bent = Image.fromarray(drawn(clean, dots="keep")[..., 0])
            relief.paste(scaled(bent, TILE), (TILE * column, 0))
            photo = Image.open(place / f"{stem}_vis.png").convert("RGB")
            for line, image in enumerate((photo, touch, Image.fromarray(clean))):
                sheet.paste(scaled(image, TILE), (TILE * column, TILE * line))
            if not column:
                row.paste(scaled(touch, PRESS), (PRESS * k, 0))
        write_image(folder / f"{k:02d}.webp", sheet)
        write_image(folder / f"{k:02d}.relief.webp", relief, quality=50)
    write_image(folder / "presses.webp", row)


def scaled(image: Image.Image, side: int) -> Image.Image:
    """Return a picture of some pixels on each side."""
    return image.resize((side, side), Image.Resampling.LANCZOS)


def write_image(path: Path, image: Image.Image, quality: int = QUALITY) -> None:
    """Write a WebP file."""
    with replacing(path) as temporary:
        image.save(temporary, "WEBP", quality=quality, method=6)


def about(name: str, domain: SimulatedDomain) -> dict[str, str]:
    """Return a domain's name, sensor, scene, and a sentence about the sensor, from the model
    that draws it.
    """
    sensor = next(key for key, value in SENSORS.items() if value is domain.sensor)
    if isinstance(domain.sensor, Sensor):
        gel = domain.sensor
        dots = "no printed dots"
        if gel.markers:
            some = f" on {100 * (1 - gel.plain_gels):.0f} % of its gels" if gel.plain_gels else ""
            dots = f"dots printed {gel.markers.pitch:g} mm apart{some}"
        words = f"A gel of {gel.field:g} mm, {len(gel.lamps)} coloured lamps, {dots}."
    elif isinstance(domain.sensor, TaximSensor):
        gelsight = sensor.removeprefix("Taxim ")
        words = f"Drawn by Taxim from its calibration of a {gelsight}; no printed dots."
    else:
        words = "No lamps and no picture of a gel: 400 measured displacements, drawn as colours."
    return {"name": name, "sensor": sensor, "scene": PLACES[domain.name], "about": words}


PLACES = {
    "TAG": "by hand, indoors and outdoors",
    "OF Real": "on a white turntable",
    "OF 2.0 A": "on white ground",
    "OF 2.0 B": "on black ground",
    "TQ-DIGIT": "on an oak desk",
    "TQ-GelMini": "on a laminate desk",
    "TQ-DuraGel": "on a cloth",
    "TQ-T3D": "on a workbench",
}


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write compact JSON."""
    write_text(path, json.dumps(content, separators=(",", ":")) + "\n")


def gathered(folder: Path, learning: Sequence[Embeddings]) -> Twins:
    """Embed the twins of a folder, with the dots kept and filled, and by relief."""
    encoder, plan = load_encoder("efficientnet-lite0"), unmet_objects()
    header = learning[0].header

    def images(kind: str, objects: Sequence[Planned]) -> list[Array]:
        of_all = [(unmet, domain) for unmet in objects for domain in SIMULATED.values()]
        return [picture(folder, unmet, domain, kind) for unmet, domain in of_all]

    def rows(pictures: Sequence[Array]) -> Array:
        return embedded(encoder, pictures).reshape(-1, len(SIMULATED), encoder.width)

    def whole(unmet: Planned) -> bool:
        pairs = (twin(unmet, domain) for domain in SIMULATED.values())
        return all(image_path(folder, pair, "vis").is_file() for pair in pairs)

    touches = images("tac", plan)
    clean = [fill_dots(picture)[0] for picture in touches]
    photographed = plan[
        : [*map(whole, plan), False].index(False) // len(header.classes) * len(header.classes)
    ]
    printed = np.flatnonzero((learning[0].tac != learning[1].tac).any(-1))
    relief = reliefs(folder, len(photographed))
    return Twins(
        vis=rows(images("vis", photographed)),
        tac=rows(touches),
        filled=rows(clean),
        relief=np.stack([np.nanmax(vectors[0], axis=0) for vectors in relief["touch"]], axis=1),
        label=np.array([header.classes.index(unmet.material) for unmet in plan]),
        objects=tuple(unmet.object for unmet in plan),
        looks_like=tuple(unmet.looks_like for unmet in plan),
        feels_like=tuple(unmet.feels_like for unmet in plan),
        header=replace(header, origin="twins simulated by omnivat, seed 0, mitsuba renderer"),
        as_filled=learning[1].header.preprocessing,
        printed=learning[0].tac[printed],
        rows=printed,
    )


def split() -> dict[str, Any]:
    """Return the loss of linear maps from the record: reading -> [dots kept, filled; by relief] ->
    term -> [mean, low, high] in points.
    """
    maps = json.loads(RECORD.read_bytes())["split"]["linear_maps"]
    terms = ("home", "sensor", "scene", "interplay", "objects", "away")
    return {
        "head": "three linear maps",
        "sources": len(maps["sources"]),
        "loss": {
            reading: [
                {term: maps[look][reading][term] for term in terms}
                for look in ("kept", "filled", "relief")
                if reading in maps[look]
            ]
            for reading in READINGS
        },
    }


def main() -> None:
    """Pack the twins, or write what the page draws of them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    step = parser.add_mutually_exclusive_group(required=True)
    step.add_argument("--pack", type=Path, metavar="FOLDER")
    step.add_argument("--page", type=Path, metavar="FOLDER")
    parser.add_argument("--learn", nargs=2, type=Path, metavar=("KEPT", "FILLED"), required=True)
    options = parser.parse_args()
    learning = [load_embeddings(file) for file in options.learn]
    with one_thread():
        if options.pack:
            write_twins(EXAMPLES / "twins.npz", gathered(options.pack, learning))
            return
        made = twins()
        domains = [about(name, SIMULATED[paper_name(name)]) for name in made.header.domains]
        learning.append(Reliefs(learning[FILLED]).source)
        content, objects = page(made, learning, reliefs(options.page, len(made.vis)), domains)
        write_json(EXAMPLES / "twins.json", content | {"split": split()})
        write_json(EXAMPLES / "twins.map.json", threads(made, learning[0]))
        sheets(made, objects, options.page, EXAMPLES / "twins")


if __name__ == "__main__":
    main()
