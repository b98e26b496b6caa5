"""ObjectFolder Real (OF Real): a hundred objects, each pressed at 30 to 50 places.

    <root>/<object>/tactile_data/<contact>/0/gelsight/<number>.png    the whole press as frames
    <root>/<object>/tactile_data/<contact>/0/<a camera>/<number>.png  camera frames
    <root>/materials.csv   object,material: copied from the data set's download page

The folder is called gelsight, the sensor in the paper GelSlim. The names of the camera folders are
unknown, so any folder of frames next to gelsight is accepted, the hand's camera first.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

from omnivat.data.materials import class_key, ruled, rules
from omnivat.data.pairs import Pair, PairSet, Tally
from omnivat.data.readers.files import folders_in, frames_in, is_file, read_names, show
from omnivat.data.splits import split_by_object
from omnivat.kit.errors import DataError
from omnivat.kit.tables import require_choice

DOMAIN = "OF Real"
TOUCH = "gelsight"
TEST_SHARE = 1_355 / (3_401 + 1_355)  # of the paper's counts
CHOICES = ("middle", "last", "all")
PREFERRED = ("hand", "third")  # words in the names of camera folders, best first


def recognises(source: Path) -> bool:
    """True if a folder has objects with tactile data."""
    return any((folder / "tactile_data").is_dir() for folder in folders_in(source))


def read(
    source: Path, *, strict: bool = False, seed: int = 0, frames: str = "middle", camera: str = ""
) -> PairSet:
    """Return the pairs of ObjectFolder Real, split by object.

    source     the folder of the object folders, "1" to "100"
    strict     leave out iron (as steel) and polycarbonate (as plastic)
    seed       of the split
    frames     frames of a press: "middle", "last" or "all"
    camera     the folder of VIS next to gelsight; "" finds one

    The paper's frames and camera are unknown. The VIS frame is at the same fraction of its
    recording. Raises DataError without a table or without pairs.
    """
    require_choice("frames", frames, CHOICES)
    left_out = Tally()
    table = source / "materials.csv"
    if not is_file(table):
        raise DataError(
            f"No table of materials at '{show(table)}'. The recordings do not name them: write the "
            "list of the download page into a CSV with the columns object,material."
        )
    named = read_names(table, "object", "material")
    pairs: Sequence[Pair] = [
        pair
        for thing in folders_in(source)
        if (thing / "tactile_data").is_dir()
        if (material := _material(thing.name, named, strict, left_out))
        for pair in _pairs(thing, material, frames, camera, left_out)
    ]
    pairs = split_by_object(pairs, seed=seed, test=TEST_SHARE)
    how = f"{frames} frame of a press, split by object"
    return left_out.result("ObjectFolder Real", source, pairs, how)


def _material(name: str, named: dict[str, str], strict: bool, left_out: Tally) -> str:
    """Return the object's material, or "" if it is left out."""
    raw = class_key(named.get(name, ""))
    material, why = ruled(rules("objectfolder").get(raw), raw, strict=strict)
    if name not in named:
        why = "the table of materials does not name it"
    if why:
        left_out.add(f"object {show(name)}", why)
    return material


def _pairs(thing: Path, material: str, choice: str, camera: str, left_out: Tally) -> Iterator[Pair]:
    for contact in folders_in(thing / "tactile_data"):
        recording = contact / "0"
        touch = list(frames_in(recording / TOUCH).values())
        seen = _camera_frames(recording, camera)
        if not touch or not seen:
            missing = f"no frames in {TOUCH}" if not touch else f"no frames of a camera {camera}"
            left_out.add(f"object {show(thing.name)}", missing.strip())
            continue
        chosen = len(touch) - 1 if choice == "last" else len(touch) // 2
        for index in range(len(touch)) if choice == "all" else (chosen,):
            yield Pair(
                vis=seen[round(index / max(1, len(touch) - 1) * (len(seen) - 1))],
                tac=touch[index],
                domain=DOMAIN,
                material=material,
                object=thing.name,
            )


def _camera_frames(recording: Path, camera: str) -> list[Path]:
    """Return the frames of the given camera, or of the best one with frames."""
    beside = [
        folder
        for folder in folders_in(recording)
        if folder.name != TOUCH and camera in ("", folder.name)
    ]
    beside.sort(
        key=lambda file: ([word not in file.name.lower() for word in PREFERRED], file.name.lower())
    )
    return next((list(frames.values()) for frames in map(frames_in, beside) if frames), [])
