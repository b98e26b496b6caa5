"""Ways to damage files, from a seed: each takes bytes and returns others, or None if it does not
apply to them.
"""

import json
import re
import struct
import zipfile
from collections.abc import Callable
from io import BytesIO
from random import Random

from benchmarks._attack_files import spoilt, spoilt_tensors

Case = dict[str, bytes]  # the files of a case by their paths
Mutation = Callable[[bytes, Random], bytes | None]
BYTES = (0, 1, 0x20, 0x7F, 0x80, 0xFF)
NUMBERS = (0, 1, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 2**31 - 1, 2**32 - 1, 2**40, 2**63 - 1, 2**64 - 1)
WORDS = (
    b"nan", b"inf", b"-1", b"0", b"1e400", b"9" * 30, b"99999999", b"null", b"true", b"{}", b"[]",
    b"", b"x" * 3000, b" " * 20_000, b"\xff\xfe", b"\\ud800", "\U0001f9be\u0301".encode(), b"\0",
    b"../../../x", b"/dev/zero", b'"', b"|", b"%s%n", b"=1+1", b"CON", b"row:0", b"{0.__class__}",
)  # fmt: skip
MOST = 1_000_000  # bytes of a case's file


def _bytes(content: bytes, chance: Random) -> bytes | None:
    """Set some bytes, more often of the first kilobyte."""
    if not content:
        return None
    changed = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 4, 16))):
        end = min(len(changed), 1000) if chance.random() < 0.6 else len(changed)
        changed[chance.randrange(end)] = chance.choice((*BYTES, chance.randrange(256)))
    return bytes(changed)


def _number(content: bytes, chance: Random) -> bytes | None:
    """Write a remarkable number of 1 to 8 bytes somewhere."""
    size = chance.choice((1, 2, 4, 8))
    if len(content) < size:
        return None
    at = chance.randrange(min(len(content), chance.choice((200, 10**9))) - size + 1)
    number: int = chance.choice(NUMBERS) % 256**size
    made = number.to_bytes(size, chance.choice(("little", "big")))
    return content[:at] + made + content[at + size :]


def _cut(content: bytes, chance: Random) -> bytes | None:
    """Keep the beginning."""
    return content[: chance.randrange(len(content))] if content else None


def _drop(content: bytes, chance: Random) -> bytes | None:
    """Leave out a part."""
    if len(content) < 2:
        return None
    at = chance.randrange(len(content))
    return content[:at] + content[at + chance.choice((1, 4, 64, 1000)) :]


def _repeat(content: bytes, chance: Random) -> bytes | None:
    """Write a part many times."""
    if not content:
        return None
    at, length = chance.randrange(len(content)), chance.choice((1, 2, 8, 100, 5000))
    part = content[at : at + length]
    return content[:at] + part * chance.choice((2, 3, 50, 2000)) + content[at:]


def _word(content: bytes, chance: Random) -> bytes | None:
    """Put a hostile word in the place of a word or number."""
    found = [m.span() for m in re.finditer(rb"[\w.+-]+|[^\w\s]", content[:200_000])]
    if not found:
        return None
    start, end = chance.choice(found)
    return content[:start] + chance.choice(WORDS) + content[end:]


def _json(content: bytes, chance: Random) -> bytes | None:
    """Change a part of a JSON value."""
    if content[:1] not in (b"{", b"["):
        return None
    try:
        return json.dumps(spoilt(json.loads(content), chance)).encode()
    except ValueError:
        return None


def _tensors(content: bytes, chance: Random) -> bytes | None:
    """Damage the header or the numbers of a safetensors file."""
    try:
        return spoilt_tensors(content, chance) if content[8:9] == b"{" else None
    except (ValueError, KeyError, TypeError, IndexError, struct.error):
        return None  # it is damaged already


def _member(content: bytes, chance: Random) -> bytes | None:
    """Damage a member of a zip archive, whose checksums then fit."""
    if content[:2] != b"PK":
        return None
    try:
        with zipfile.ZipFile(BytesIO(content)) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
            packing = {member.filename: member.compress_type for member in archive.infolist()}
    except Exception:  # it is damaged already
        return None
    if not members:
        return None
    name = chance.choice(list(members))
    way = chance.choice((_bytes, _number, _word, _repeat, _cut, _json))
    changed, renamed = way(members[name], chance), name
    if chance.random() < 0.1:
        renamed = chance.choice(("../" * 9 + name, "/" + name, name + "x", name.upper(), "\u0301"))
    with BytesIO() as handle:
        with zipfile.ZipFile(handle, "w") as archive:
            for member, inner in members.items():
                mine = member == name
                archive.writestr(
                    renamed if mine else member,
                    changed if mine and changed is not None else inner,
                    packing[member],
                )
        return handle.getvalue()


MUTATIONS: dict[str, Mutation] = {
    "bytes": _bytes,
    "number": _number,
    "cut": _cut,
    "drop": _drop,
    "repeat": _repeat,
    "word": _word,
    "json": _json,
    "tensors": _tensors,
    "member": _member,
}


def mutated(case: Case, other: Case, chance: Random) -> tuple[str, Case]:
    """Return the name of a way, and a case with one file damaged in it.

    other  a case of the same reader, whose file may be joined to this one's
    """
    name = chance.choice(list(case))
    if chance.random() < 0.05:
        if chance.random() < 0.5 and len(case) > 1:
            return "missing", {key: content for key, content in case.items() if key != name}
        own, more = case[name], other.get(name, b"")
        at, end = (chance.randrange(len(text) + 1) for text in (own, more))
        return "splice", {**case, name: (own[:at] + more[end:])[:MOST]}
    while True:
        way = chance.choice(list(MUTATIONS))
        if (changed := MUTATIONS[way](case[name], chance)) is not None:
            return way, {**case, name: changed[:MOST]}
        if not case[name]:
            return "bytes", {**case, name: chance.choice(WORDS)}
