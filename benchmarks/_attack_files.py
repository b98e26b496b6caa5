"""Hostile files and requests from a seed: images, heads, sets and JSON."""

import json
import random
import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

from PIL import Image

KINDS = ("PNG", "JPEG", "WEBP", "GIF", "BMP", "TIFF")
ATOMS: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 3.5, 10**18, 10**400, 1e308, -1e308, float("nan"), float("inf"),
    "", "a" * 5000, "\ud800", "\x00", "../../etc/passwd", "/etc/passwd", "<script>", "row:1",
    [], {}, [[]], [1], {"a": 1}, [None], ["\ud800"], ["a", "a"], {"": {"": []}},
)  # fmt: skip
TYPES = ("F32", "F16", "I64", "U8", "C64", "BOOL", "F8", 3, None, ["F32"])


def images(chance: random.Random, count: int) -> Iterator[bytes]:
    """Yield damaged and oversized image files."""
    for k in range(count):
        kind = KINDS[k % len(KINDS)]
        mode = chance.choice(["RGB", "L", "P", "RGBA", "1"] if kind != "JPEG" else ["RGB", "L"])
        size = chance.choice([(40, 30), (9, 300), (256, 256), (1, 1)])
        with BytesIO() as handle:
            Image.new(mode, size, 1).save(handle, kind)
            content = bytearray(handle.getvalue())
        for _ in range(chance.randint(0, 6)):
            place = chance.randrange(min(len(content), 300))
            content[place] = chance.choice([0, 1, 0x7F, 0x80, 0xFF, chance.randrange(256)])
        if chance.random() < 0.3:
            content = content[: chance.randrange(len(content))]
        if chance.random() < 0.2:
            content += bytes(chance.randrange(256) for _ in range(500))
        yield bytes(content)


def spoilt(value: Any, chance: random.Random) -> Any:
    """Return a copy of a JSON value with one part replaced by something hostile."""
    if isinstance(value, dict) and value and chance.random() < 0.85:
        name = chance.choice(list(value))
        return {**value, name: spoilt(value[name], chance)}
    if isinstance(value, list) and value and chance.random() < 0.6:
        place = chance.randrange(len(value))
        return [*value[:place], spoilt(value[place], chance), *value[place + 1 :]]
    return chance.choice(ATOMS)


def heads(folder: Path, chance: random.Random, count: int) -> Iterator[dict[str, bytes]]:
    """Yield the files of heads, profiles among them, with one damaged part."""
    names = ["weights.safetensors", "settings.json", "metrics.json"]
    names += [
        f"{k}.safetensors"
        for k in ("profile", "familiarity")
        if (folder / f"{k}.safetensors").is_file()
    ]
    good = {name: (folder / name).read_bytes() for name in names}
    for k in range(count):
        name = ("settings.json", *names)[k % (len(names) + 1)]
        if name.endswith(".safetensors"):
            changed = spoilt_tensors(good[name], chance)
        else:
            changed = json.dumps(spoilt(json.loads(good[name]), chance)).encode()
        if chance.random() < 0.1:
            changed = changed[: chance.randrange(len(changed))]
        yield {**good, name: changed}


def sets(file: Path, chance: random.Random, count: int) -> Iterator[dict[str, bytes]]:
    """Yield embeddings files with one damaged part."""
    good = file.read_bytes()
    for k in range(count):
        changed = spoilt_rows(good, chance) if k % 3 == 0 else spoilt_tensors(good, chance)
        yield {"embeddings.safetensors": changed}


def _parts(content: bytes) -> tuple[dict[str, Any], bytes]:
    (length,) = struct.unpack_from("<Q", content)
    return json.loads(content[8 : 8 + length]), content[8 + length :]


def _joined(table: Any, body: bytes) -> bytes:
    text = json.dumps(table).encode()
    text += b" " * (-len(text) % 8)
    return struct.pack("<Q", len(text)) + text + body


def spoilt_tensors(content: bytes, chance: random.Random) -> bytes:
    """Return a safetensors file with damaged header, types, metadata or numbers."""
    table, body = _parts(content)
    way = chance.randrange(6)
    name = chance.choice([n for n in table if n != "__metadata__"])
    if way == 0:
        table = spoilt(table, chance)
    elif way == 1:
        table[name]["dtype"] = chance.choice(TYPES)
    elif way == 2:
        table["__metadata__"] = spoilt(table.get("__metadata__", {}), chance)
    elif way == 3:
        start, end = (min(k, len(body)) for k in table[name]["data_offsets"])
        filled = chance.choice([b"\xff", b"\x7f", b"\x00\x00\xc0\x7f", b"\x7b"])
        filling = (filled * (end - start))[: end - start]
        body = body[:start] + filling + body[end:]
    elif way == 4:
        table |= {f"more {k}": table[name] for k in range(chance.choice([1, 70, 5000]))}
    else:
        return struct.pack("<Q", chance.choice([0, 2**63, 2**40, 9])) + content[8:]
    return _joined(table, body)


def spoilt_rows(content: bytes, chance: random.Random) -> bytes:
    """Return an embeddings file with damaged names."""
    table, body = _parts(content)
    start, end = table["rows"]["data_offsets"]
    rows = json.loads(body[start:end])
    text = json.dumps(spoilt(rows, chance)).encode()
    text = text[: end - start].ljust(end - start)
    return _joined(table, body[:start] + text + body[end:])


def questions(chance: random.Random, count: int) -> Iterator[dict[str, Any]]:
    """Yield requests with valid and hostile values under the page's names."""
    names = ("vis", "tac", "order", "stage", "map", "point", "nodes", "method", "head", "lessons",
             "reading", "modality", "row", "rows", "class", "domain", "pair", "k", "label",
             "measure", "set", "pairs", "photos", "touches", "profile", "taught", "mode", "colour",
             "theme", "parts", "compare")  # fmt: skip
    for _ in range(count):
        question = {
            name: chance.choice(ATOMS) for name in chance.sample(names, chance.randint(0, 6))
        }
        for name in ("vis", "tac"):
            if chance.random() < 0.5:
                question[name] = f"row:{chance.randrange(40)}"
        yield question
