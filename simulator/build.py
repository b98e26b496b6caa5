"""Build a simulated set of pairs on disk from a seed; an interrupted build resumes.

A few pairs of a set can be copied as small examples."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import partial
from importlib.util import find_spec
from itertools import chain
from os import cpu_count
from pathlib import Path

import numpy as np
from PIL import Image

from omnivat.data.domains import paper_name, simulated
from omnivat.data.images import read_image
from omnivat.data.pairs import TEXTS, Pair, PairSet
from omnivat.data.rest import REST
from omnivat.kit.errors import DataError, MissingPackageError
from omnivat.kit.files import replacing
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.stages import IMAGES
from omnivat.kit.tables import entry
from omnivat.kit.threads import in_processes
from simulator.domains import NUMBERS, SIMULATED, SimulatedDomain
from simulator.drawing import drawn, resting
from simulator.noise import Array
from simulator.photograph import Renderer
from simulator.plan import COLUMNS, PAIRS, Planned, classes, planned, write_table
from simulator.sensors import SensorModel, TaximSensor
from simulator.vision import rendered

Wanted = tuple[Planned, str]  # a pair, and "vis" or "tac"
QUALITY = 94  # of JPEG: over a quarter of the PNG; no subsampling, for the colours of a gel


def write_examples(made: PairSet, folder: Path, *, each: int = 2) -> list[Path]:
    """Write `<folder>/<domain>/<class>/<name>_{vis,tac}.jpg`; return the files.

    made  a simulated set on disk
    each  pairs of each class of each domain, of test objects; fewer if there are not enough

    Images keep their full size, with JPEG's loss. Raises DataError if the set has no test pairs.
    """
    classes: dict[tuple[str, str], list[Pair]] = defaultdict(list)
    for pair in made.pairs:
        if pair.split == "test":
            classes[pair.domain, pair.material].append(pair)
    if not classes:
        raise DataError(
            "The set has no test objects to take examples from; ask for 4 pairs per class or more."
        )
    written = []
    for (domain, material), things in classes.items():
        for pair in chosen(things, each):
            for kind, image in (("vis", pair.vis), ("tac", pair.tac)):
                file = (
                    folder / domain / material / f"{image.stem.removesuffix(f'_{kind}')}_{kind}.jpg"
                )
                with replacing(file) as temporary:
                    read_image(image).save(temporary, "JPEG", quality=QUALITY, subsampling=0)
                written.append(file)
    return written


def chosen(things: list[Pair], count: int) -> list[Pair]:
    """Return `count` of `things`, half of them (rounded down) visual imitators if possible."""
    alike = [pair for pair in things if pair.looks_like]
    plain = [pair for pair in things if not pair.looks_like]
    few = max(min(count // 2, len(alike)), count - len(plain))
    return spread(plain, count - few) + spread(alike, few)


def spread(things: list[Pair], count: int) -> list[Pair]:
    """Return `count` of `things`, evenly spaced, or all of them."""
    count = min(count, len(things))
    return [things[(2 * index + 1) * len(things) // (2 * count)] for index in range(count)]


def simulate(
    out: Path | str,
    *,
    domains: Sequence[str | SimulatedDomain] | None = None,
    pairs_per_class: int = PAIRS,
    seed: int = 0,
    size: int = 224,
    workers: int | None = None,
    touches: bool = False,
    renderer: Renderer = rendered,
    on_step: OnStep = ignore,
) -> PairSet:
    """Write `<out>/<domain>/<class>/<name>_{vis,tac}.png` and `<out>/pairs.csv`; return the pairs.

    Each domain's folder also gets `rest.png`, its sensor while it touches nothing.

    domains          names, with or without "-sim", or domains of your own; None: the shipped eight
    pairs_per_class  of each class of each domain
    size             side of an image in pixels
    workers          processes; None means one for each core
    touches          alone, without photographs
    renderer         by Mitsuba, or `photograph.plain`: flat surfaces without dependencies

    The same arguments give the same bytes. Complete images are kept, so an interrupted build
    resumes. Delete the folder to start again, for instance with another seed.

    Raises MissingNameError for an unknown domain, DataError for an invalid number,
    MissingPackageError if the renderer or Taxim is not installed.
    """
    plan = list(_plan(domains, pairs_per_class))
    # Alternate between classes, so that an interrupted build has a mixed sample.
    in_turn = sorted(plan, key=lambda pair: int(pair.object.rsplit("-", 1)[1]))
    kinds = ("tac",) if touches else ("vis", "tac")
    images = [(pair, kind) for pair in in_turn for kind in kinds]
    return draw_set(
        Path(out), plan, images, origin=f"simulated by omnivat, seed {seed}",
        seed=seed, size=size, workers=workers, renderer=renderer, on_step=on_step,
    )  # fmt: skip


def draw_set(
    out: Path,
    plan: Sequence[Planned],
    images: Sequence[Wanted],
    *,
    origin: str,
    seed: int,
    size: int,
    workers: int | None,
    renderer: Renderer,
    on_step: OnStep,
) -> PairSet:
    """Draw the images that are not yet complete on disk, write the table, and return the pairs.

    Without images of one kind, the table has no column for it, and the other stands for both. Every
    domain's folder also gets the no-contact picture of its sensor. The first image is drawn here,
    so that a renderer of one's own fails before anything is written, the others in processes.

    Raises MissingPackageError, before any work, with all that the images need.
    """
    work = partial(draw_to, out=out, seed=seed, size=size, renderer=renderer)
    todo = [image for image in images if not is_whole(image_path(out, *image), size)]
    rests = {out / simulated(pair.domain) / REST: pair.made.sensor for pair in plan}
    rests = {path: sensor for path, sensor in rests.items() if not is_whole(path, size)}
    touched = [pair.made.sensor for pair, kind in todo if kind == "tac"]
    require_packages(
        [*touched, *rests.values()],
        photographs=renderer is rendered and any(kind == "vis" for _, kind in todo),
    )
    done = len(images) - len(todo)
    on_step(Step(done=done, total=len(images), text="already there"))
    first, rest = todo[:1], todo[1:]
    count = min(workers or cpu_count() or 1, len(rest))
    others = in_processes(work, rest, count) if count > 1 else map(work, rest)
    for name in chain(map(work, first), others):
        done += 1
        on_step(Step(done=done, total=len(images), text=name))
    for path, sensor in rests.items():
        write_image(path, resting(sensor, size=size))
    kinds = [name for name in IMAGES if any(kind == name for _, kind in images)]
    pairs = tuple(
        Pair(
            vis=image_path(out, pair, kinds[0]),
            tac=image_path(out, pair, kinds[-1]),
            domain=simulated(pair.domain),
            alone=kinds[0] if len(kinds) == 1 else "",
            **{name: getattr(pair, name) for name in ("material", *TEXTS)},
        )
        for pair in plan
    )
    write_table(out, pairs, [name for name in COLUMNS if name in kinds or name not in IMAGES])
    return PairSet(pairs=pairs, origin=origin, simulated=True)


def require_packages(sensors: Sequence[SensorModel], *, photographs: bool) -> None:
    """Raise MissingPackageError if packages are missing for touches by `sensors`, or for
    photographs by Mitsuba; the sentence lists everything that is needed.
    """
    needs: dict[str, tuple[str, ...]] = {}
    if photographs:
        needs["photographs"] = ("mitsuba",)
    if any(isinstance(sensor, TaximSensor) for sensor in sensors):
        needs["touches of OF 2.0 A and B"] = ("taxim", "jax")
    missing = [name for names in needs.values() for name in names if find_spec(name) is None]
    if missing:
        wanted = ", ".join(f"{what} need {' and '.join(names)}" for what, names in needs.items())
        raise MissingPackageError(
            f"Nothing was drawn: {wanted}, and {', '.join(missing)}"
            f" {'is' if len(missing) == 1 else 'are'} not installed. Run `pip install -r"
            " simulator/requirements.txt`, or draw touches of the five gels, which need none of"
            " these: `python -m simulator twins --gels --out DIR`."
        )


def draw_to(image: Wanted, *, out: Path, seed: int, size: int, renderer: Renderer) -> str:
    """Draw one image and write it, completely or not at all."""
    path = image_path(out, *image)
    write_image(path, drawn(*image, seed=seed, size=size, renderer=renderer))
    return path.relative_to(out).as_posix()


def _plan(
    domains: Sequence[str | SimulatedDomain] | None, pairs_per_class: int
) -> Iterator[Planned]:
    if not 1 <= pairs_per_class <= NUMBERS:
        raise DataError(
            f"{pairs_per_class} pairs of a class were requested; choose 1 to {NUMBERS:,}."
        )
    for wanted in [*SIMULATED] if domains is None else domains:
        domain = (
            wanted
            if isinstance(wanted, SimulatedDomain)
            else entry(SIMULATED, paper_name(wanted), kind="domain")
        )
        for material in classes(domain):
            yield from planned(domain, material, pairs=pairs_per_class)


def image_path(out: Path, pair: Planned, kind: str) -> Path:
    """Return the file of a pair's "vis" or "tac" image."""
    return out / simulated(pair.domain) / pair.material / f"{Path(pair.object).name}_{kind}.png"


def is_whole(path: Path, size: int) -> bool:
    """True if a file decodes to an image of the right size."""
    try:
        with Image.open(path) as image:
            image.load()
            return image.size == (size, size)
    except (OSError, SyntaxError):  # Pillow raises SyntaxError on a broken PNG chunk
        return False


def write_image(path: Path, image: Array) -> None:
    """Write an image (H, W, 3), 0 to 1, as PNG, completely or not at all."""
    with replacing(path) as temporary:
        Image.fromarray(np.round(image * 255).astype(np.uint8)).save(
            temporary, format="PNG", compress_level=6
        )
