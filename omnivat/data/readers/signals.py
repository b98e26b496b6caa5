"""Contact signals in one dimension: recordings of vibrations, cut into windows.

Three layouts: that of dexrob/BioTac_slide_20_50 (`mat1/mat1_10_bio.csv`), any folder
`<domain>/<class>/<name>.csv` or `.wav`, and a folder of .npz files with the arrays `signal` and
`material`. All leave out what they cannot read, with the reason.
"""

import csv
import re
import wave
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from omnivat.data.embeddings import Embeddings, Header, indices
from omnivat.data.foreign import PREFIX, read_columns
from omnivat.data.materials import class_key, in_order
from omnivat.data.pairs import Skipped
from omnivat.data.readers.files import folders_in, show, visible
from omnivat.data.store import ROW_NAMES
from omnivat.data.strips import ENCODER, PREPROCESSING, READER, STRIPES
from omnivat.kit.errors import DataError, SettingsError
from omnivat.kit.tables import load

LAYOUT = "<domain>/<class>/<name>.csv or .wav, or .npz with signal (N, n) and material (N,)"
BIOTAC = re.compile(r"mat\d+_\d+_bio\.csv", re.IGNORECASE)
DYNAMIC = tuple(f"pac{k}" for k in range(1, 23))  # 22 samples of dynamic pressure in a row
MOST = 10_000_000  # samples of one recording
SIGNAL_READERS = {  # tried in this order
    "biotac": "omnivat.data.readers.signals:read_biotac",
    "arrays": "omnivat.data.readers.signals:read_arrays",
    "folder": "omnivat.data.readers.signals:read_folder",
}
Signal = NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """One signal (n,), and where it comes from."""

    signal: Signal
    domain: str
    material: str
    name: str  # path in the folder


@dataclass(frozen=True, slots=True, kw_only=True)
class Recordings:
    """What a reader returns."""

    recordings: tuple[Recording, ...]
    skipped: tuple[Skipped, ...]
    origin: str


def read_signals(source: Path | str, *, reader: str = "auto") -> Recordings:
    """Return the recordings in a folder; errors as in `signal_embeddings`.

    reader  a name in SIGNAL_READERS; "auto": BioTac if any file has such a name, arrays if the
            folder has an .npz file, a folder of signals otherwise
    """
    root = Path(source)
    if not root.is_dir():
        raise DataError(f"'{show(root)}' is not a folder; expected a folder of {LAYOUT}.")
    if reader == "auto":
        reader = "biotac" if any(_biotac_files(root)) else "arrays" if _array_files(root) else "folder"
    found: Recordings = load(SIGNAL_READERS, reader, kind="reader of signals")(root)
    if not found.recordings:
        why = f" ({found.skipped[0].what}: {found.skipped[0].why})" if found.skipped else ""
        raise DataError(f"'{show(root)}' has no recording{why}; expected {LAYOUT}.")
    return found


def read_biotac(root: Path) -> Recordings:
    """Return the vibrations of a copy of dexrob/BioTac_slide_20_50; its materials are classes.

    A row of a file holds the 22 samples pac1 to pac22 of 10 ms; rows are laid end to end, so the rate is 2.2 kHz.
    """
    return _collected(
        root,
        [("BioTac", file.name.partition("_")[0].lower(), file) for file in _biotac_files(root)],
        lambda file: _columns(file, DYNAMIC).reshape(-1),
        "BioTac vibrations, 22 samples of dynamic pressure a row",
    )


def read_folder(root: Path) -> Recordings:
    """Return the recordings of `<domain>/<class>/<name>.csv` or `.wav`.

    A CSV's last column is the signal; a first line without numbers is its header. Of a WAV with
    several channels, the first one counts.
    """
    files = [
        (domain.name, class_key(kind.name), kind / entry.name)
        for domain in folders_in(root)
        for kind in folders_in(domain)
        for entry in visible(kind)
    ]
    return _collected(root, files, _any, f"folder of signals '{root.name}'")


def read_arrays(root: Path) -> Recordings:
    """Return the recordings of .npz files: `signal` (N, n), `material` (N,), perhaps `domain` (N,).

    A file without `domain` is a domain of its name.
    """
    recordings: list[Recording] = []
    skipped = []
    for file in _array_files(root):
        try:
            recordings += _rows_of(file)
        except DataError as error:
            skipped.append(Skipped(what=show(file.relative_to(root)), why=str(error)))
    origin = f"arrays of signals in '{root.name}'"
    return Recordings(recordings=tuple(recordings), skipped=tuple(skipped), origin=origin)


def _rows_of(file: Path) -> Iterator[Recording]:
    found = read_columns(file)
    for name in ("signal", "material"):
        if name not in found:
            raise DataError(f"lacks the array '{name}'")
    signal = found["signal"]
    if signal.ndim != 2 or signal.dtype.kind not in "iuf" or not np.isfinite(signal).all():
        raise DataError("'signal' is no table of finite numbers, a recording a row")
    names = [found["material"], found.get("domain", np.full(len(signal), file.stem))]
    if any(one.shape != (len(signal),) for one in names):
        raise DataError(f"'material' or 'domain' has no name for each of {len(signal)} recordings")
    return (
        Recording(
            signal=row.astype(np.float32),
            domain=str(domain),
            material=class_key(str(material)),
            name=f"{file.name}:{index}",
        )
        for index, (row, material, domain) in enumerate(zip(signal, *names, strict=True))
    )


def signal_embeddings(
    source: Path | str,
    *,
    window: int = STRIPES,
    most: int = 8,
    test_share: float = 0.4,
    seed: int = 0,
    reader: str = "auto",
) -> tuple[Embeddings, tuple[Skipped, ...]]:
    """Return windows of all recordings as embeddings, and what was left out.

    window      samples, 8 or more; 64 fits the encoder `strip`, so pictures of stripes can be predicted as well
    most        windows of a recording, evenly spaced
    test_share  of the recordings of each class; a recording is one object, never in both parts

    A window is centred and scaled to a largest magnitude of 1. There is no photo: VIS repeats TAC, so train with
    modalities=tac. Raises DataError without two classes or any window, SettingsError for a setting out of range.
    """
    if window < 8 or most < 1 or not 0 <= test_share < 1:
        raise SettingsError(
            f"window is {window}, most {most} and test_share {test_share}; choose 8 or more, "
            "1 or more, and a share below 1."
        )
    found = read_signals(source, reader=reader)
    tests = _tests(found.recordings, test_share, seed)
    rows = [
        (cut, one, start, "test" if index in tests else "train")
        for index, one in enumerate(found.recordings)
        for start, cut in _windows(one.signal, window, most)
    ]
    classes = in_order({one.material for _, one, _, _ in rows})
    if len(classes) < 2:
        raise DataError(
            f"'{show(Path(source))}' has windows of {window} samples in {len(classes)} classes; "
            "two or more are needed. Choose a shorter window or add recordings."
        )
    vectors, owners = np.stack([cut for cut, *_ in rows]), [one for _, one, _, _ in rows]
    domains = tuple(dict.fromkeys(one.domain for one in owners))
    texts = {name: [""] * len(rows) for name in ROW_NAMES}
    texts["vis"] = texts["tac"] = [f"{one.name}#{start}" for _, one, start, _ in rows]
    texts["object"] = [one.name for one in owners]
    texts["split"] = [split if test_share else "" for *_, split in rows]
    strip = window == STRIPES
    header = Header(
        encoder=ENCODER if strip else f"{PREFIX}signal {window}",
        weights_hash=READER,
        preprocessing=PREPROCESSING if strip else f"windows of {window} samples, largest is 1",
        domains=domains,
        classes=classes,
        origin=f"{found.origin}; VIS repeats TAC",
    )
    made = Embeddings(
        header=header,
        vis=vectors,
        tac=vectors.copy(),
        domain=indices(domains, [one.domain for one in owners]),
        label=indices(classes, [one.material for one in owners]),
        rows=texts,
    )
    return made, found.skipped


def _tests(recordings: tuple[Recording, ...], share: float, seed: int) -> set[int]:
    """Return the indices of the test recordings: a share of each class of each domain."""
    random, chosen, groups = np.random.default_rng(seed), set[int](), defaultdict[tuple[str, str], list[int]](list)
    for index, one in enumerate(recordings):
        groups[one.domain, one.material].append(index)
    for group in groups.values():
        chosen.update(random.permutation(group)[: round(share * len(group))].tolist())
    return chosen


def _windows(signal: Signal, window: int, most: int) -> Iterator[tuple[int, Signal]]:
    """Yield (start, window) without overlap, evenly spaced; constant ones are left out."""
    count = len(signal) // window
    for k in sorted({int(share * count) for share in np.arange(most) / most}):
        cut = signal[k * window : (k + 1) * window] if k < count else signal[:0]
        cut = cut - cut.mean() if len(cut) else cut
        if len(cut) and np.abs(cut).max() > 0:
            yield k * window, (cut / np.abs(cut).max()).astype(np.float32)


def _biotac_files(root: Path) -> Iterator[Path]:
    for folder in (root, *folders_in(root), *(f for top in folders_in(root) for f in folders_in(top))):
        yield from (folder / e.name for e in visible(folder) if BIOTAC.fullmatch(e.name))


def _array_files(root: Path) -> list[Path]:
    return [root / e.name for e in visible(root) if e.name.lower().endswith(".npz")]


def _collected(
    root: Path, files: list[tuple[str, str, Path]], read: Callable[[Path], NDArray[np.float64]], origin: str
) -> Recordings:
    """Read (domain, class, file) one by one; a file that fails is left out with the reason."""
    recordings, skipped = [], []
    for domain, material, file in files:
        name = show(file.relative_to(root))
        try:
            signal = np.asarray(read(file), dtype=np.float32)
        except (DataError, OSError, EOFError, ValueError, wave.Error, csv.Error) as error:
            skipped.append(Skipped(what=name, why=str(error).splitlines()[0][:120] or "unreadable"))
            continue
        recordings.append(Recording(signal=signal, domain=domain, material=material, name=name))
    return Recordings(recordings=tuple(recordings), skipped=tuple(skipped), origin=origin)


def _any(file: Path) -> NDArray[np.float64]:
    if (kind := file.suffix.lower()) not in (".csv", ".wav"):
        raise DataError("neither .csv nor .wav")
    return _wav(file) if kind == ".wav" else _columns(file, ())[:, 0]


def _columns(file: Path, names: tuple[str, ...]) -> NDArray[np.float64]:
    """Return the named columns (n, len(names)) of a CSV, or its last one; finite numbers only."""
    with file.open(newline="", encoding="utf-8-sig") as handle:
        rows = list(islice(csv.reader(handle), MOST + 2))
    rows = [row for row in rows if any(cell.strip() for cell in row)]
    header = [cell.strip().lower() for cell in rows[0]] if rows and not _numeric(rows[0]) else []
    body = rows[bool(header) :]
    missing = [name for name in names if name not in header]
    if missing:
        raise DataError(f"lacks the column {missing[0]}")
    places = [header.index(name) for name in names] or [-1]
    if not 0 < len(body) <= MOST:
        raise DataError(f"has {'too many' if body else 'no'} rows of numbers")
    values = np.array([[float(row[k]) for k in places] for row in body if len(row) >= len(header)])
    if not len(values) or not np.isfinite(values).all():
        raise DataError("has cells that are not finite numbers")
    return values


def _numeric(row: list[str]) -> bool:
    try:
        return bool([float(cell) for cell in row if cell.strip()])
    except ValueError:
        return False


def _wav(file: Path) -> NDArray[np.float64]:
    """Return the first channel of a PCM file of 8, 16, 24 or 32 bits, in units of full scale."""
    with wave.open(str(file), "rb") as sound:
        width, channels, count = sound.getsampwidth(), sound.getnchannels(), sound.getnframes()
        if not 0 < count <= MOST:
            raise DataError(f"has {count} samples; expected 1 to {MOST:,}")
        data = np.frombuffer(sound.readframes(count), np.uint8)
    bytes_ = data[: len(data) // (width * channels) * width * channels].reshape(-1, channels, width)[:, 0]
    if width == 1:
        return (bytes_[:, 0].astype(np.float64) - 128) / 128
    whole = np.zeros((len(bytes_), 4), np.uint8)
    whole[:, 4 - width :] = bytes_  # little-endian: the sign is in the last byte
    return np.asarray(whole.view("<i4")[:, 0] / 2.0**31)
