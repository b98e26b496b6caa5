"""Every reader of other people's files, with small good files to begin from."""

import json
import struct
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from pickle import dumps
from typing import Any

import numpy as np
from PIL import Image

from benchmarks._attack_costly import encoded
from benchmarks._fuzz_mutations import Case
from omnivat.kit.tables import need

CLASSES = ("wood", "steel")
TABLE = b"vis,tac,domain,material,object\na.png,b.png,A,wood,o1\nb.png,a.png,B,steel,o2\n"
PAGE = "samples/1/"  # of a sample of ObjectFolder Real
MARKDOWN = b"| 1 | mug | Ceramic | 2 | fork | Steel |\n|---|---|---|---|---|---|\n"


@dataclass(frozen=True, slots=True)
class Reader:
    """`seeds` writes good cases into folders; `read` reads one, or raises the project's error."""

    seeds: Callable[[Path], dict[str, Any]]
    read: Callable[[Path], object]


def files_in(folder: Path) -> Case:
    """Return the files below a folder."""
    found = sorted(file for file in folder.rglob("*") if file.is_file())
    return {file.relative_to(folder).as_posix(): file.read_bytes() for file in found}


def _only(folder: Path) -> Path:
    """Return the one file of a case; a missing one keeps its reader's sentence."""
    return next(iter(sorted(folder.iterdir())), folder / "missing.npz")


def _picture(side: int = 24) -> Image.Image:
    return Image.fromarray(np.random.default_rng(0).integers(0, 255, (side, side, 3), np.uint8))


def _pictures(_: Path) -> dict[str, Any]:
    picture = _picture()
    kinds = {"PNG": "RGB", "JPEG": "RGB", "WEBP": "RGBA", "GIF": "P", "BMP": "L", "TIFF": "I;16"}
    made = {kind: encoded(picture.convert(mode), kind) for kind, mode in kinds.items()}
    made |= {"PPM": encoded(picture, "PPM"), "JPEG2000": encoded(picture, "JPEG2000")}
    return {f"a.{kind.lower()}": content for kind, content in made.items()}


def _read_picture(folder: Path) -> object:
    from omnivat.data.images import read_image

    return read_image(_only(folder))


def _films(folder: Path) -> dict[str, Any]:
    import av

    for name, codec in (("a.mp4", "libx264"), ("b.mkv", "mpeg4"), ("c.avi", "mjpeg")):
        with av.open(str(folder / name), "w") as container:
            stream: Any = container.add_stream(codec, rate=10)
            stream.width = stream.height = 32
            stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
            for k in range(8):
                picture = np.full((32, 32, 3), (30 * k, 9, 200), np.uint8)
                container.mux(stream.encode(av.VideoFrame.from_ndarray(picture)))
            container.mux(stream.encode())
    return files_in(folder)


def _read_film(folder: Path) -> object:
    from omnivat.data.recordings.tracks import Film
    from omnivat.data.recordings.writing import moments

    track = Film(file=_only(folder))
    times = moments({"tac": track}, None, 2, "contact")["tac"]
    return list(track.pictures(times))


def _tables(folder: Path) -> dict[str, Any]:
    openpyxl = need("openpyxl", purpose="a table")
    made: dict[str, Any] = {}
    rows = [line.split(",") for line in TABLE.decode().split()]
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    book.save(folder / "t.xlsx")
    pictures = {f"{name}.png": encoded(_picture(), "PNG") for name in "ab"}
    for name, content in (
        ("t.csv", TABLE),
        ("t.tsv", TABLE.replace(b",", b"\t")),
        ("u.csv", TABLE.decode().encode("utf-16")),
        ("t.xlsx", (folder / "t.xlsx").read_bytes()),
    ):
        made[name] = {name: content, **pictures}
    film = _films(folder)["b.mkv"]
    made["films"] = {"t.csv": b"tac,material,start,end\nb.mkv,wood,0,0.5\n", "b.mkv": film}
    return made


def _read_table(folder: Path) -> object:
    from omnivat.data.readers import read_pairs
    from omnivat.data.recordings import clips_of, write_pairs

    tables = [f for f in folder.iterdir() if f.suffix in (".csv", ".tsv", ".xlsx")]
    table = tables[0] if tables else folder / "t.csv"
    write_pairs(clips_of(table), folder.with_name("out"), frames=1)
    return read_pairs(table).pairs


def _columns(folder: Path) -> dict[str, Any]:
    import h5py
    import pyarrow
    from pyarrow import parquet
    from safetensors.numpy import save_file

    rows = np.random.default_rng(0).random((4, 6)).astype("f4")
    texts: dict[str, Any] = {"material": ["wood", "steel"] * 2, "domain": ["A"] * 4}
    np.savez(folder / "a.npz", vis=rows, tac=rows, **texts)
    np.savez_compressed(folder / "b.npz", tac=rows, **texts)
    save_file({"vis": rows, "tac": rows}, folder / "c.safetensors")
    table = pyarrow.table({"vis": rows.tolist(), "tac": rows.tolist(), **texts})
    parquet.write_table(table, folder / "d.parquet")
    with h5py.File(folder / "e.h5", "w") as file:
        file["vis"], file["tac"] = rows, rows
        file["material"] = texts["material"]
    head = [f"{half}_{k}" for half in ("vis", "tac") for k in range(6)]
    lines = [",".join((*head, "material"))]
    lines += [",".join((*map(str, [*row, *row]), "wood")) for row in rows]
    (folder / "f.csv").write_text("\n".join(lines))
    return files_in(folder)


def _read_columns(folder: Path) -> object:
    from omnivat.data.foreign import import_embeddings

    return import_embeddings(_only(folder), encoder="x", domain="A", material="wood")


def _stored(folder: Path) -> dict[str, Any]:
    import h5py
    import pyarrow
    from pyarrow import parquet

    pictures = np.stack([np.asarray(_picture())] * 3)
    label = ["wood", "steel", "wood"]
    np.savez_compressed(folder / "a.npz", vis=pictures, tac=pictures, material=label)
    with h5py.File(folder / "b.h5", "w") as file:
        file.create_dataset("tac", data=pictures, compression="gzip")
        file["material"] = label
    cell = {"bytes": encoded(_picture(), "PNG"), "path": "x.png"}
    table = pyarrow.table({"rgb": [cell] * 3, "gelsight": [cell] * 3, "label": label})
    parquet.write_table(table, folder / "c.parquet")
    return files_in(folder)


def _read_imported(folder: Path) -> object:
    from omnivat.data.recordings import clips_of, write_pairs

    inner = [path for path in sorted(folder.iterdir()) if path.suffix in (".hapt", ".touch")]
    files = [path for path in sorted(folder.iterdir()) if path.is_file()]
    source = inner[0] if inner else files[0] if len(files) == 1 else folder
    return write_pairs(clips_of(source), folder.with_name("out"), frames=1)


def _recordings(folder: Path) -> dict[str, Any]:
    import h5py
    import pyarrow
    from pyarrow import parquet

    frames = np.stack([np.asarray(_picture())] * 3)
    with BytesIO() as handle:
        np.save(handle, frames)
        array = handle.getvalue()
    manifest = {"sensor": {"type": "DIGIT", "serial": "D1"}, "sampling": {"rate_hz": 30.0}}
    hapt = {"m.hapt/manifest.json": json.dumps(manifest).encode(), "m.hapt/raw/data.npy": array}
    hapt["m.hapt/labels.json"] = b'{"material": "wood", "object": "o"}'

    def packed(text: bytes) -> bytes:
        return struct.pack("<I", len(text)) + text

    shot = struct.pack("<III", *frames[0].shape) + frames[0].tobytes()
    events = [packed(struct.pack("<32sd", b"camera", k / 30) + shot) for k in range(2)]
    stream = packed(b"camera") + struct.pack("<I", 2) + b"".join(events)
    chunk = struct.pack("<I", 1) + packed(b"thumb") + struct.pack("<I", 1) + stream
    config = {"sensors": [{"sensor_name": "thumb", "sensor_type": "Digit", "serial_id": "D1"}]}
    with h5py.File(folder / "a.touch", "w") as file:
        file["config"] = json.dumps(config)
        kind = h5py.vlen_dtype(np.uint8)
        chunks = file.create_dataset("sensor_chunks", (1,), kind)
        chunks[0] = np.frombuffer(chunk, np.uint8)
    camera = "observation.images.gelsight"
    features = {camera: {"dtype": "image", "shape": [24, 24, 3]}}
    info = {"codebase_version": "v2.1", "fps": 10, "chunks_size": 1000, "features": features}
    info["data_path"] = "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet"
    cell = {"bytes": encoded(_picture(), "PNG"), "path": None}
    numbers = {"episode_index": [0] * 3, "frame_index": [0, 1, 2], "timestamp": [0.0, 0.1, 0.2]}
    parquet.write_table(pyarrow.table({**numbers, camera: [cell] * 3}), folder / "p")
    lerobot = {
        "meta/info.json": json.dumps(info).encode(),
        "meta/episodes.jsonl": b'{"episode_index": 0, "length": 3, "tasks": ["wood"]}\n',
        "data/chunk-000/episode_000000.parquet": (folder / "p").read_bytes(),
    }
    return {"hapt": hapt, "a.touch": (folder / "a.touch").read_bytes(), "lerobot": lerobot}


def _archives(_: Path) -> dict[str, Any]:
    made = {}
    for name, packing in (("a.zip", zipfile.ZIP_STORED), ("b.zip", zipfile.ZIP_DEFLATED)):
        with BytesIO() as handle:
            with zipfile.ZipFile(handle, "w", packing) as archive:
                archive.writestr("dataset/wood_1.mov", bytes(500))
                archive.writestr("contact_indoor.csv", TABLE)
            made[name] = handle.getvalue()
    return made


def _read_archive(folder: Path) -> object:
    from omnivat.data.fetching.archive import unpacked, zipped

    with zipped([_only(folder)]) as store:
        found = list(store.contents(store.names))
    return found, unpacked([_only(folder)], folder.with_name("out"))


def _heights(_: Path) -> dict[str, Any]:
    heights = np.random.default_rng(0).random((12, 12)).astype("f4")
    return {f"{k}.pkl": dumps(heights, protocol=k) for k in (0, 2, 4, 5)}


def _read_heights(folder: Path) -> object:
    from omnivat.data.fetching.heights import drawn, load_heights

    return drawn(load_heights(_only(folder).read_bytes(), "x.pkl"))


def _profiles(folder: Path) -> dict[str, Any]:
    from omnivat.data.profile import Channels, Profile
    from omnivat.data.profile_file import save_profile
    from omnivat.data.relief import Lamps

    channels = Channels(mean=np.ones(8, "f4"), variance=np.ones(8, "f4"), count=3)
    numbers: dict[str, Any] = {"ratio": 0.1, "confidence": 0.9, "pictures": 5}
    lamps = Lamps(colours=np.eye(3, 2), background=np.asarray(_picture(8)), **numbers)
    bare = Profile(channels={"tac": channels}, key=("e", "w", "p"), domain="A")
    save_profile(folder / "a", bare)
    save_profile(folder / "b", replace(bare, lamps=lamps))
    return files_in(folder)


def _read_profile(folder: Path) -> object:
    from omnivat.data.profile_file import load_profile, save_profile

    found = load_profile(_only(folder))
    save_profile(folder.with_name("out"), found)  # what loads can be saved
    return found


def _sets(folder: Path) -> dict[str, Any]:
    from omnivat import default_embeddings, load_embeddings, save_embeddings
    from omnivat.data.relief import Lamps

    some = load_embeddings(default_embeddings()).select(np.arange(0, 60, 10))
    some = replace(some, vis=some.vis[:, :8], tac=some.tac[:, :8], vis_flip=None, tac_flip=None)
    save_embeddings(folder / "a.safetensors", some)
    numbers: dict[str, Any] = {"ratio": 0.1, "confidence": 0.9, "pictures": 5}
    domain, lamps = some.header.domains[0], Lamps(colours=np.eye(3, 2), background=None, **numbers)
    lit = replace(some.header, lamps={domain: lamps}, tac_rest={domain: ("a" * 16,)})
    save_embeddings(folder / "b.safetensors", replace(some, header=lit), dtype="float16")
    return {f.name: f.read_bytes() for f in folder.glob("*.safetensors")}


def _read_set(folder: Path) -> object:
    from omnivat import load_embeddings

    found = load_embeddings(_only(folder))
    return found.select(np.arange(len(found))).sampled(2)


def _heads(folder: Path) -> dict[str, Any]:
    import torch

    from omnivat.head.calibration import Familiarity
    from omnivat.head.checkpoint import Head, save_head
    from omnivat.head.head import OmniVaT
    from omnivat.head.settings import HeadSettings

    encoder = {"name": "e", "weights_hash": "w", "preprocessing": "p"}
    model = OmniVaT(HeadSettings(classes=CLASSES, input_width=8, lang_width=4, width=8))
    rows = {name: torch.eye(8)[:2] for name in ("vis", "tac", "relief")}
    known = Familiarity(rows=rows, quantiles={name: torch.arange(3.0) for name in rows})
    head = Head(model=model, encoder=encoder, provenance={"source": "A"}, familiarity=known)
    save_head(folder / "a", head)
    save_head(folder / "b", replace(head, familiarity=None))
    return {name: files_in(folder / name) for name in "ab"}


def _read_head(folder: Path) -> object:
    import torch

    from omnivat.head.checkpoint import load_head

    head = load_head(folder)
    rows = torch.ones(1, head.settings.input_width)
    return head.model(rows, rows)


def _twins(folder: Path) -> dict[str, Any]:
    from omnivat.measure.twins import TEXTS, twins, write_twins

    shipped = twins()
    few: dict[str, Any] = {name: np.ones((3, 8, 8), "f4") for name in ("vis", "tac", "relief")}
    texts: dict[str, Any] = {name: getattr(shipped, name)[:3] for name in TEXTS}
    printed: dict[str, Any] = {"printed": np.ones((2, 8), "f4"), "rows": shipped.rows[:2]}
    made = replace(shipped, filled=few["tac"] * 2, label=shipped.label[:3], **printed)
    write_twins(folder / "a.npz", replace(made, **few, **texts))
    return files_in(folder)


def _read_twins(folder: Path) -> object:
    from omnivat import twins

    found = twins(_only(folder))
    return found.pairs(found.header.domains[0])


def _checkpoints(folder: Path) -> dict[str, Any]:
    import torch
    from safetensors.torch import save_file

    state = {"module.a.weight": torch.ones(3, 4), "module.a.bias": torch.ones(3)}
    torch.save({"state_dict": state, "epoch": 3}, folder / "a.pt")
    torch.save(state, folder / "b.bin", _use_new_zipfile_serialization=False)
    save_file(state, folder / "c.safetensors")
    made: dict[str, Any] = files_in(folder)
    index = json.dumps({"weight_map": dict.fromkeys(state, "c.safetensors")}).encode()
    made["index"] = {"model.safetensors.index.json": index, "c.safetensors": made["c.safetensors"]}
    return made


def _read_checkpoint(folder: Path) -> object:
    from omnivat.encoders.weights import read_weights

    index = folder / "model.safetensors.index.json"
    return read_weights(index if index.is_file() else folder, "a model", r"a\.weight")["a.weight"]


def _pages(_: Path) -> dict[str, Any]:
    return {"page.md": MARKDOWN * 3, "b.md": b"| 1 | a \\| b | glass |\n" * 4}


def _read_page(folder: Path) -> object:
    from omnivat.data.fetching.layouts import LAYOUTS

    text = _only(folder).read_bytes().decode(errors="replace")
    names = [f"{PAGE}tactile/0.png", f"{PAGE}visual/0.png", "page.md"]
    return list(LAYOUTS["objectfolder-real"](names, lambda _: text))


def _banks(folder: Path) -> dict[str, Any]:
    from safetensors.numpy import save_file

    metadata = {"format": "omnivat-lang-1", "classes": json.dumps(CLASSES), "origin": "x"}
    save_file({"embeddings": np.ones((2, 3, 4), "f4")}, folder / "a.safetensors", metadata)
    return files_in(folder)


def _read_bank(folder: Path) -> object:
    from omnivat.encoders.lang.bank import load_bank

    return load_bank(_only(folder)).hash


READERS = {
    "pictures": Reader(_pictures, _read_picture),
    "films": Reader(_films, _read_film),
    "tables": Reader(_tables, _read_table),
    "columns": Reader(_columns, _read_columns),
    "stored": Reader(_stored, _read_imported),
    "recordings": Reader(_recordings, _read_imported),
    "archives": Reader(_archives, _read_archive),
    "heights": Reader(_heights, _read_heights),
    "profiles": Reader(_profiles, _read_profile),
    "sets": Reader(_sets, _read_set),
    "heads": Reader(_heads, _read_head),
    "twins": Reader(_twins, _read_twins),
    "checkpoints": Reader(_checkpoints, _read_checkpoint),
    "pages": Reader(_pages, _read_page),
    "banks": Reader(_banks, _read_bank),
}
