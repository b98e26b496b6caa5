"""What the head for one's own pictures makes of real pairs that no choice has seen: `python -m
benchmarks.own EMBEDDINGS`. Without EMBEDDINGS, the rules of familiarity are compared.

EMBEDDINGS are those of ObjectFolder Real (`omnivat fetch objectfolder-real`, `omnivat embed`). The
profile is of all its pairs, without labels. Right readings and familiar pictures go into the record,
and the former beside the head, where the page reads them. Odd pictures are drawn here: twelve kinds,
as they come and each kind moved by a profile of its own.

A rule of familiarity is the number of nearest training images whose mean cosine counts, before or
after a profile. Prediction: after a profile odd pictures lie among the training images, whatever the
number; before it, ten neighbours tell more of them than one. Choice: of the rules that tell 95 % of
the odd pictures of each modality, the one that calls most pictures of left-out simulated sensors
familiar. No real picture takes part.
"""

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from benchmarks.measure import machine
from omnivat.data.profile import channels_of, drawn_profiles, moved, profile_of, profiled
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.encoders import load_encoder
from omnivat.encoders.base import for_modality
from omnivat.head import teach
from omnivat.head.calibration import NEIGHBOURS, UNLIKE, nearest_cosines
from omnivat.head.checkpoint import Head, load_head
from omnivat.head.heads import default_embeddings, own_head
from omnivat.head.teach import Lesson
from omnivat.kit.files import write_json
from omnivat.kit.schema import read_object
from omnivat.kit.stages import IMAGES
from omnivat.measure.evaluate import label_map, predicted_probabilities
from omnivat.training.own import KEPT, level

OUT = Path("docs/benchmarks/own.json")
SIDE, EACH = 224, 10  # pixels, and pictures of a kind
READINGS = ("fused", *IMAGES)
PICTURES = 20  # without labels, of a left-out sensor
Rows = NDArray[Any]
AS_THEY_COME, PROFILED = "as they come", "profile"
Draw = Callable[[np.random.Generator, ImageDraw.ImageDraw], object]


def main() -> None:
    """Read the real pairs and the odd pictures; write both records."""
    parser = argparse.ArgumentParser(prog="benchmarks.own", description=__doc__)
    parser.add_argument("embeddings", type=Path, nargs="?")
    head, place = load_head(own_head()), parser.parse_args().embeddings
    before = read_object(OUT)
    if place is None:
        return write_json(OUT, before | {"rules": rules(load_embeddings(default_embeddings()))})
    data = load_embeddings(place)
    real = read(head, data)
    record = {"real": real, "taught": taught(head, data), "familiar": familiar(head, data)}
    write_json(OUT, before | {"machine": machine(), **record, "odd": odd(head)})
    metrics = own_head() / "metrics.json"
    write_json(metrics, read_object(metrics) | {"real": real})


def read(head: Head, data: Embeddings) -> dict[str, Any]:
    """Return the pairs that each reading has right, as they come and with the profile of all."""
    truth = label_map(head.settings.classes, data.header.classes)[data.label]
    near = head.profiled(data, [profile_of(data, domain=data.header.domains[0])])
    record: dict[str, Any] = {"pairs": len(data), "always": int(np.bincount(truth).max())}
    for how, some in ((AS_THEY_COME, data), (PROFILED, near)):
        shares = predicted_probabilities(head.model, some)
        record[how] = {n: int((shares[n].argmax(-1).numpy() == truth).sum()) for n in READINGS}
    return record


def taught(head: Head, data: Embeddings) -> dict[str, int]:
    """Return the pairs that are right by heads taught without their fold, and without their object
    alone.
    """
    near = head.profiled(data, [profile_of(data, domain=data.header.domains[0])])
    vis, tac = (torch.from_numpy(np.array(getattr(near, name), np.float32)) for name in IMAGES)
    lessons = [
        Lesson(
            label=data.header.classes[label],
            vis=vis[row : row + 1],
            tac=tac[row : row + 1],
            object=data.rows["object"][row],
        )
        for row, label in enumerate(data.label)
    ]
    alone = 0
    for k, one in enumerate(lessons):
        other = teach.taught(head, [*lessons[:k], *lessons[k + 1 :]])
        best = int(other.model(one.vis, one.tac).probabilities.argmax())
        alone += other.settings.classes[best] == one.label
    return {"folds": teach.judged(head, lessons).after, "objects": alone}


def familiar(head: Head, data: Embeddings) -> dict[str, int]:
    """Return the pictures of each modality that are called familiar; a profile plays no part."""
    assert head.familiarity
    vis, tac = (torch.from_numpy(np.array(getattr(data, name), np.float32)) for name in IMAGES)
    looks = head.familiarity.look(vis, tac)
    return {name: sum(one[name]["quantile"] >= UNLIKE for one in looks) for name in IMAGES}


def odd(head: Head) -> dict[str, dict[str, dict[str, int]]]:
    """Return modality -> kind -> odd pictures of EACH that are told as unlike, as they come, and
    if a profile of their kind were applied first.
    """
    assert head.familiarity
    found: dict[str, dict[str, dict[str, int]]] = {}
    for name, strange in odd_rows(head.encoder["name"]).items():
        found[name] = {}
        source = head.source_profile.channels[name]
        for kind, rows in strange.items():
            shifted = moved(rows, channels_of(rows), source)
            found[name][kind] = {
                how: sum(
                    one[name]["quantile"] < UNLIKE
                    for one in head.familiarity.look(**{"vis": None, "tac": None, name: some})
                )
                for how, some in (
                    (AS_THEY_COME, torch.from_numpy(rows)),
                    (PROFILED, torch.from_numpy(shifted.astype(np.float32))),
                )
            }
    return found


def odd_rows(encoder_name: str) -> dict[str, dict[str, Rows]]:
    """Return modality -> kind -> embeddings (EACH, W) of odd pictures, as they come."""
    encoder = load_encoder(encoder_name, dots="fill")
    found: dict[str, dict[str, Rows]] = {}
    for name in IMAGES:
        own = for_modality(encoder, name)
        found[name] = {
            kind: own.embed(torch.stack([own.preprocess(one) for one in pictures])).numpy()
            for kind, pictures in kinds().items()
        }
    return found


def rules(data: Embeddings) -> dict[str, dict[str, dict[str, float]]]:
    """Return rule -> modality -> "familiar", the share of pictures of a left-out simulated sensor
    that are called familiar, and "told", the share of odd pictures that are told as unlike: means
    over the sensors.
    """
    strange = odd_rows(data.header.encoder)
    shares: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for name in data.header.domains:
        others = [other for other in data.header.domains if other != name]
        levelled, base = level(data, others)
        rows = np.concatenate([levelled.rows_of(other, split="train") for other in others])[::KEPT]
        objects = np.array(data.rows["object"])[rows]
        owner = torch.from_numpy(np.unique(objects, return_inverse=True)[1])
        test = data.select(data.rows_of(name, split="test"))
        profiles, _ = drawn_profiles(data, "", PICTURES, seed=0)
        near = profiled(test, {name: profiles[name]}, base)
        for image in IMAGES:
            known = torch.from_numpy(np.array(getattr(levelled, image)[rows], np.float32))
            own = nearest_cosines(known, known, owner, owner)
            odd_ones = list(strange[image].values())
            shifted = [moved(one, channels_of(one), base.channels[image]) for one in odd_ones]
            for how, seen, unseen in ((AS_THEY_COME, test, odd_ones), (PROFILED, near, shifted)):
                pictures = getattr(seen, image), np.concatenate(unseen)
                each = [
                    nearest_cosines(torch.from_numpy(np.float32(some)), known) for some in pictures
                ]
                for count in (1, NEIGHBOURS):
                    least = own[:, :count].mean(1).quantile(UNLIKE)
                    like, odd_like = (
                        float((one[:, :count].mean(1) >= least).double().mean()) for one in each
                    )
                    rule = f"{count} nearest, {how}"
                    shares.setdefault((rule, image), []).append((like, 1 - odd_like))
    found: dict[str, dict[str, dict[str, float]]] = {}
    for (rule, image), some in shares.items():
        mean = np.mean(some, axis=0).round(3).tolist()
        found.setdefault(rule, {})[image] = dict(zip(("familiar", "told"), mean, strict=True))
    return found


def kinds() -> dict[str, list[Image.Image]]:
    """Return the odd pictures, by kind."""
    return {name: [make(np.random.default_rng(k)) for k in range(EACH)] for name, make in _makers()}


def _makers() -> Iterator[tuple[str, Callable[[np.random.Generator], Image.Image]]]:
    y, x = np.mgrid[:SIDE, :SIDE] / SIDE

    def colour(random: np.random.Generator) -> Any:
        return tuple(random.integers(0, 255, 3).tolist())

    def grey(levels: Any) -> Image.Image:
        return Image.fromarray(np.asarray(levels).astype(np.uint8)).convert("RGB")

    def field(size: int, top: float) -> Callable[[np.random.Generator], Image.Image]:
        return lambda random: Image.fromarray(
            (random.random((size, size, 3)) * top).astype(np.uint8)
        ).resize((SIDE, SIDE), Image.Resampling.BICUBIC)

    def drawn(draw: Draw, ground: str = "white") -> Callable[[np.random.Generator], Image.Image]:
        def make(random: np.random.Generator) -> Image.Image:
            picture = Image.new("RGB", (SIDE, SIDE), ground)
            draw(random, ImageDraw.Draw(picture))
            return picture

        return make

    def letters(random: np.random.Generator, pen: ImageDraw.ImageDraw) -> None:
        for line in range(int(random.integers(6, 18))):
            words = "".join(random.choice(list("abcdefghij klmno"), 34))
            pen.text((5, 4 + 12 * line), words, fill="black")

    def discs(random: np.random.Generator, pen: ImageDraw.ImageDraw) -> None:
        for a, b, size in random.integers(10, 180, (12, 3)).tolist():
            pen.ellipse([a, b, a + size, b + size], fill=colour(random))

    def chart(random: np.random.Generator, pen: ImageDraw.ImageDraw) -> None:
        heights = random.integers(20, 200, 10).tolist()
        pen.line([(10 + 20 * k, height) for k, height in enumerate(heights)], "blue", 2)
        pen.line([(10, 10), (10, 210), (215, 210)], "black")

    def face(random: np.random.Generator, pen: ImageDraw.ImageDraw) -> None:
        a, b = random.integers(80, 140, 2).tolist()
        pen.ellipse([a - 60, b - 75, a + 60, b + 75], fill="bisque")
        for eye in (-30, 15):
            pen.ellipse([a + eye, b - 20, a + eye + 15, b - 8], fill="black")
        pen.arc([a - 25, b + 10, a + 25, b + 45], 0, 180, fill="red", width=4)

    def screen(random: np.random.Generator, pen: ImageDraw.ImageDraw) -> None:
        for top in range(10, 210, 40):
            pen.rectangle([10, top, int(random.integers(60, 210)), top + 28], fill=colour(random))
            pen.text((14, top + 8), "Button", fill="white")

    def checkers(random: np.random.Generator) -> Image.Image:
        count = random.integers(3, 20)
        return grey(20 + 200 * ((np.floor(count * x) + np.floor(count * y)) % 2))

    yield "noise", field(SIDE, 255)
    yield "dark", field(SIDE // 2, 60)
    yield "clouds", field(8, 255)
    yield "plain", lambda random: Image.new("RGB", (SIDE, SIDE), colour(random))
    yield "gradient", lambda random: grey(30 + random.integers(50, 200) * (x + y) / 2)
    yield "checkers", checkers
    yield "stripes", lambda random: grey(128 + 100 * np.sin(random.integers(30, 250) * x))
    yield "text", drawn(letters)
    yield "discs", drawn(discs, "grey")
    yield "chart", drawn(chart)
    yield "face", drawn(face, "tan")
    yield "screen", drawn(screen)


if __name__ == "__main__":
    main()
