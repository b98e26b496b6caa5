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
import base64
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from PIL import Image
from sklearn.linear_model import LogisticRegression
from sklearn.neighbors import NearestNeighbors

from benchmarks.relief import Reliefs
from omnivat.data.domains import paper_name
from omnivat.data.dots import fill_dots
from omnivat.data.embeddings import Embeddings
from omnivat.data.materials import MATERIALS
from omnivat.data.profile import Channels, channels_of, shrunk
from omnivat.data.relief import NoLampsError, drawn, lamps
from omnivat.data.store import load_embeddings
from omnivat.encoders import load_encoder
from omnivat.head.heads import EXAMPLES
from omnivat.kit.files import replacing, write_text
from omnivat.kit.threads import one_thread
from omnivat.maps.projection import pca, torch_umap
from omnivat.measure.twins import Twins, twins, write_twins
from simulator.build import image_path
from simulator.domains import SIMULATED, SimulatedDomain
from simulator.plan import Planned
from simulator.sensors import SENSORS, Sensor, TaximSensor
from simulator.twins import twin, unmet_objects

Array = NDArray[Any]
RECORD = Path("docs/benchmarks/twins.json")
Fill = Callable[[Array], Array]
READINGS = {"touch": ("tac",), "photo": ("vis",), "both": ("vis", "tac")}
PICTURES = (5, 20, 50, 200)  # without labels
# twins are tested in thirds, with pictures of the other two; draws of these pictures
PARTS, DRAWS = 3, 5
LIT = (0, 5, 20)  # pictures that give lamps, and a profile beside them; more change little
KEPT, FILLED, RELIEF = 0, 1, 2  # how a touch is read: dots as printed, filled, by relief
C = 0.003
TILE, PRESS, QUALITY = 144, 56, 80  # pixels of a picture, of a small one; of WebP


@dataclass(frozen=True, slots=True, kw_only=True)
class Plain:
    """A logistic regression on standardised rows, and the statistics that it learned them with."""

    model: LogisticRegression
    own: Channels

    def probabilities(self, rows: Array, known: Channels | None = None) -> Array:
        """Return probabilities (n, K) of rows (n, W), standardised by the source's statistics,
        or `known` ones.
        """
        seen = known or self.own
        found: Array = self.model.predict_proba(
            (rows - seen.mean) / (np.sqrt(seen.variance) + 1e-6)
        )
        return found


def learned(rows: Array, labels: Array) -> Plain:
    """Fit the regression to unit rows (n, W)."""
    own = channels_of(rows)
    model = LogisticRegression(C=C, max_iter=1500)
    return Plain(
        model=model.fit((rows - own.mean) / (np.sqrt(own.variance) + 1e-6), labels), own=own
    )


def rows_of(vectors: Mapping[str, Array], reading: str) -> Array:
    """Return unit rows (..., N, W) of a reading, side by side for both."""
    parts = [vectors[name] for name in READINGS[reading]]
    count = min(part.shape[-2] for part in parts)  # of the twins, some have no photograph
    return np.concatenate(
        [
            p[..., :count, :] / np.linalg.norm(p[..., :count, :], axis=-1, keepdims=True)
            for p in parts
        ],
        axis=-1,
    )


def thirds(count: int, classes: int) -> list[Array]:
    """Return PARTS sets of indices; objects come in rounds of the classes, so that each part has
    as many of all.
    """
    return [np.flatnonzero(np.arange(count) // classes % PARTS == part) for part in range(PARTS)]


def pools(count: int, pictures: int, classes: int, *, seed: int) -> list[tuple[Array, Array]]:
    """Return for each third its indices, and those of `pictures` of the others, known without
    labels.
    """
    random = np.random.default_rng([seed, pictures])
    return [
        (part, random.permutation(np.setdiff1d(np.arange(count), part))[:pictures])
        for part in thirds(count, classes)
    ]


def predicted(head: Plain, rows: Array, pictures: int, classes: int, *, seed: int) -> Array:
    """Return probabilities (N, K) of rows (N, W), with `pictures` rows of the other thirds known
    without labels. Rows may be (PARTS, N, W): as they are read by what is known in each third.
    """
    rows = np.broadcast_to(rows, (PARTS, *rows.shape[-2:]))
    found = np.zeros((rows.shape[1], len(head.model.classes_)))
    for own, (part, pool) in zip(
        rows, pools(rows.shape[1], pictures, classes, seed=seed), strict=True
    ):
        known = shrunk(channels_of(own[pool]), head.own) if pictures else None
        found[part] = head.probabilities(own[part], known)
    return found


def share(right: Array) -> list[float]:
    """Return the mean of (N,) and its 95 % interval over objects."""
    mean, half = right.mean(), 1.96 * right.std(ddof=1) / len(right) ** 0.5
    return [round(float(v), 3) for v in (mean, max(mean - half, 0), min(mean + half, 1))]


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """Predictions of one head on all twins, by number of pictures (R) and target (T)."""

    right: Array  # (R, T, N) share of draws that are right
    said: Array  # (R, T, N) class of the first draw

    @property
    def count(self) -> int:
        """N, how many twins were predicted."""
        return int(self.right.shape[-1])


def seen(
    head: Plain, rows: Sequence[Array], label: Array, source: int, classes: int, look: int
) -> Seen:
    """Predict twins with no picture, and with each of `PICTURES`, of the target.

    rows  (S, N, W), or (S, PARTS, N, W), for each number of pictures, and last for the source
    """
    targets, draws = len(rows[0]), 1 if look == RELIEF else DRAWS
    shape = (1 + len(PICTURES), targets, len(label))
    right, said = np.zeros(shape), np.zeros(shape, int)
    for r, pictures in enumerate((0, *PICTURES)):
        for target in range(targets):
            known, read = (0, rows[-1]) if target == source else (pictures, rows[r])
            known = min(known, LIT[-1]) if look == RELIEF else known
            count = draws if known else 1
            for draw in range(count):
                shares = predicted(head, read[target], known, classes, seed=draw)
                answer = head.model.classes_[shares.argmax(1)]
                right[r, target] += answer == label
                if not draw:
                    said[r, target] = answer
            right[r, target] /= count
    return Seen(right=right, said=said)


def everything(
    made: Twins, learning: Sequence[Embeddings], relief: Mapping[str, Sequence[Array]]
) -> dict[tuple[str, int, int], Seen]:
    """Return (reading, source, look) -> predictions; a look is that of training and test.

    learning  the set that the heads learn from, by look
    relief    "touch", "both" -> `by_relief` of its twins by each sensor
    """
    found = {}
    classes = len(made.header.classes)
    for look, pairs in enumerate(learning):
        for reading in READINGS if not look else ("touch", "both"):
            rows = [_tested(made, reading, look, r, relief) for r in range(2 + len(PICTURES))]
            count = rows[0].shape[-2]
            for source, name in enumerate(made.header.domains):
                own = pairs.in_domain(name, split="train")
                head = learned(rows_of(own.vectors, reading), own.label)
                found[reading, source, look] = seen(
                    head, rows, made.label[:count], source, classes, look
                )
    return found


def _tested(
    made: Twins, reading: str, look: int, r: int, relief: Mapping[str, Sequence[Array]]
) -> Array:
    """Return unit rows of twins (S, N, W), or (S, PARTS, N, W), with the pictures of number r."""
    vis = np.swapaxes(made.vis, 0, 1)
    if look == RELIEF:
        tac = np.stack([one[min(r, len(LIT) - 1)] for one in relief[reading]])
        vis = np.broadcast_to(vis[:, None], (*tac.shape[:2], *vis.shape[1:]))
    else:
        tac = np.swapaxes(made.filled if look else made.tac, 0, 1)
    return rows_of({"vis": vis, "tac": tac}, reading)


def by_relief(pictures: Sequence[Array], count: int, classes: int, encoder: Any) -> Array:
    """Return embeddings (LIT, PARTS, count, W) of the first touches of a sensor by relief.

    pictures  touches (H, W, 3), their dots filled

    Each third, and its pool, is read by the lamps of the pool, and where it gives none, or with no
    picture, by each touch's own.
    """
    found = np.full((len(LIT), PARTS, count, encoder.width), np.nan, np.float32)
    alone = embedded(encoder, [drawn(one, dots="keep") for one in pictures[:count]])
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
    that the fill
    turns right on most sensors, and one that stays wrong on most of them."""
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
                    [
                        cell(heads[reading, source, look], source, r)
                        for r in range(1 + len(PICTURES))
                    ]
                    for look in ((KEPT,) if reading == "photo" else (KEPT, FILLED, RELIEF))
                ]
                for source in sources
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
            reading: [min(n, some.count * (PARTS - 1) // PARTS) for n in PICTURES]
            for reading, some in ((r, heads[r, 0, 0]) for r in READINGS)
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


def sheets(made: Twins, objects: Sequence[int], pictures: Path, fill: Fill, folder: Path) -> None:
    """Write the pictures of the shown objects: a sheet for each, and a row of their first touches.

    pictures  the folder that `python -m simulator twins` wrote
    fill      picture (H, W, 3) -> the same with the printed dots filled
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
            clean = Image.fromarray(fill(np.asarray(touch)))
            bent = Image.fromarray(drawn(np.asarray(clean), dots="keep")[..., 0])
            relief.paste(bent.resize((TILE, TILE), Image.Resampling.LANCZOS), (TILE * column, 0))
            for line, image in enumerate(
                (Image.open(place / f"{stem}_vis.png").convert("RGB"), touch, clean)
            ):
                sheet.paste(
                    image.resize((TILE, TILE), Image.Resampling.LANCZOS),
                    (TILE * column, TILE * line),
                )
            if not column:
                row.paste(touch.resize((PRESS, PRESS), Image.Resampling.LANCZOS), (PRESS * k, 0))
        write_image(folder / f"{k:02d}.webp", sheet)
        write_image(folder / f"{k:02d}.relief.webp", relief, quality=50)
    write_image(folder / "presses.webp", row)


def write_image(path: Path, image: Image.Image, quality: int = QUALITY) -> None:
    """Write a WebP file."""
    with replacing(path) as temporary:
        image.save(temporary, "WEBP", quality=quality, method=6)


def moved(rows: Array) -> tuple[Array, Array, Array]:
    """Return rows (N, S, W) of S sensors three ways: as they come, with each sensor's mean moved
    onto the common
    mean, and with mean and spread moved. All are in units of the common spread."""
    flat = rows.reshape(-1, rows.shape[-1])
    as_they_come = (rows - flat.mean(0)) / (flat.std(0) + 1e-6)
    centred = as_they_come - as_they_come.mean(0)
    return as_they_come, centred, centred / (centred.std(0) + 1e-6)


def own_twin(rows: Array) -> Array:
    """Return (S, S): how many of N presses by one sensor have their own twin as nearest press by
    another, a share.
    """
    sensors = rows.shape[1]
    found = np.ones((sensors, sensors))
    for other in range(sensors):
        near = NearestNeighbors(n_neighbors=1).fit(rows[:, other])
        for first in range(sensors):
            if first != other:
                nearest = near.kneighbors(rows[:, first], return_distance=False)[:, 0]
                found[first, other] = (nearest == np.arange(len(rows))).mean()
    return found


def threads(made: Twins, learning: Embeddings) -> dict[str, Any]:
    """Return the contents of `examples/twins.map.json`: maps of all touches (dots as printed) in
    the three ways of `moved`.

    label     a digit for each press: its class
    pca, umap  by way: positions of press 0 by sensor 0 to S - 1, then of press 1, ...; little-
               endian 16-bit pairs of
              one box for the three ways, in base64. UMAP goes on from the map of the way before
    own_twin  [sensor][way]: share of presses whose nearest press by another sensor is their own
              twin, mean of the others
    gap       by way: distance between the means of two sensors' unit rows, mean over pairs of
              sensors
    accuracy  by way: share right on another sensor, mean over sources and targets, of a head on
              standardised rows that is given the mean, or mean and spread, of all presses
    """
    rows = rows_of({"tac": made.tac}, "touch")
    ways = moved(rows)
    points = [torch.from_numpy(way.reshape(-1, way.shape[-1])).float() for way in ways]
    basis = pca.basis(torch.cat(points))
    flat = [basis.place(some).numpy() for some in points]
    chained: list[Array] = []
    for some in points:
        start = torch.from_numpy(chained[-1]) if chained else None
        chained.append(torch_umap.project(some, start=start).numpy())
    near = [own_twin(way) for way in ways]
    away = ~np.eye(rows.shape[1], dtype=bool)
    return {
        "presses": len(rows),
        "label": "".join(map(str, made.label)),
        "pca": packed(flat),
        "umap": packed(chained),
        "own_twin": [
            [round(float(w[s][away[s]].mean()), 3) for w in near] for s in range(rows.shape[1])
        ],
        "own_twin_mean": [round(float(w[away].mean()), 3) for w in near],
        "gap": [round(gap(way), 3) for way in ways],
        "accuracy": accuracies(made, rows, learning),
    }


def packed(maps: Sequence[Array]) -> list[str]:
    """Return maps (N, 2) as 16-bit positions in their common box, in base64."""
    every = np.concatenate(maps)
    low, size = every.min(0), np.ptp(every, axis=0).max()
    return [
        base64.b64encode(((m - low) / size * 65_535).round().astype("<u2").tobytes()).decode()
        for m in maps
    ]


def gap(rows: Array) -> float:
    """Return the mean distance between the mean unit rows of two sensors."""
    means = (rows / np.linalg.norm(rows, axis=-1, keepdims=True)).mean(0)
    apart = np.linalg.norm(means[:, None] - means, axis=-1)
    return float(apart[np.triu_indices(len(means), 1)].mean())


def accuracies(made: Twins, rows: Array, learning: Embeddings) -> list[float]:
    """Return the mean share right on another sensor, three ways."""
    found = []
    for source, name in enumerate(made.header.domains):
        own = learning.in_domain(name, split="train")
        head = learned(rows_of(own.vectors, "touch"), own.label)
        tested = np.isin(made.label, head.model.classes_)
        for target in range(rows.shape[1]):
            if target != source:
                seen = channels_of(rows[:, target])
                for known in (None, replace(seen, variance=head.own.variance), seen):
                    answer = head.model.classes_[
                        head.probabilities(rows[:, target], known).argmax(1)
                    ]
                    found.append((answer == made.label)[tested].mean())
    return [round(float(v), 3) for v in np.reshape(found, (-1, 3)).mean(0)]


def about(name: str, domain: SimulatedDomain) -> dict[str, str]:
    """Return a domain's name, sensor, scene, and a sentence about the sensor, from the model
    that draws it.
    """
    sensor = next(key for key, value in SENSORS.items() if value is domain.sensor)
    if isinstance(domain.sensor, Sensor):
        gel = domain.sensor
        dots = "no printed dots"
        if gel.markers:
            share = (
                f" on {1 - gel.plain_gels:.0%} of its gels".replace("%", " %")
                if gel.plain_gels
                else ""
            )
            dots = f"dots printed {gel.markers.pitch:g} mm apart{share}"
        words = f"A gel of {gel.field:g} mm, {len(gel.lamps)} coloured lamps, {dots}."
    elif isinstance(domain.sensor, TaximSensor):
        words = (
            f"Drawn by Taxim from its calibration of a {sensor.removeprefix('Taxim ')}; no printed"
            " dots."
        )
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
        relief=np.stack([np.nanmax(one[0], axis=0) for one in relief["touch"]], axis=1),
        label=np.array([header.classes.index(unmet.material) for unmet in plan]),
        objects=tuple(unmet.object for unmet in plan),
        looks_like=tuple(unmet.looks_like for unmet in plan),
        feels_like=tuple(unmet.feels_like for unmet in plan),
        header=replace(header, origin="twins simulated by omnivat, seed 0, mitsuba renderer"),
        as_filled=learning[1].header.preprocessing,
        printed=learning[0].tac[printed],
        rows=printed,
    )


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
        sheets(made, objects, options.page, lambda p: fill_dots(p)[0], EXAMPLES / "twins")


if __name__ == "__main__":
    main()
