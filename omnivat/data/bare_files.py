"""An image file without the parts that its pixels do not need, and its rotation.

A decoder unpacks texts, profiles and EXIF tables; a megabyte of them may take gigabytes. They are
left out before it reads the file.
"""

import struct
from collections.abc import Iterable

from omnivat.data.image_files import TIFF_TAGS, jpeg_segments, png_chunks, tiff_table

PNG_PARTS = (b"IHDR", b"PLTE", b"tRNS", b"IDAT", b"IEND")
NOTES = (*range(0xE1, 0xEE), 0xEF, 0xFE)  # segments of a JPEG; Adobe's 0xEE has the colours
EXIF = b"Exif\0\0"
ORIENTATION = 0x0112
MOST_ENTRIES = 512


def bare_file(content: bytes, kind: str) -> tuple[bytes, int | None]:
    """Return the file as the decoder needs it, and its rotation.

    content  a file that `image_file` accepts, of that `kind`
    return   the same bytes if there is nothing to leave out; the rotation as in EXIF, 1 to 8, or
             None for a kind whose rotation the decoder knows
    """
    found = {"PNG": _png, "JPEG": _jpeg, "TIFF": _tiff, "WEBP": _webp}.get(kind)
    return found(content) if found else (content, 1 if kind in ("GIF", "BMP") else None)


def rotation(exif: bytes) -> int:
    """Return the rotation of an EXIF table, 1 to 8; 1 for a damaged one.

    >>> rotation(b"MM\\0*\\0\\0\\0\\x08\\0\\1\\1\\x12\\0\\3\\0\\0\\0\\1\\0\\6\\0\\0")
    6
    """
    exif = exif.removeprefix(EXIF)
    order = {b"II": "<", b"MM": ">"}.get(exif[:2])
    if order is None:
        return 1
    try:
        (at,) = struct.unpack_from(order + "I", exif, 4)
        (many,) = struct.unpack_from(order + "H", exif, at)
        for start in range(at + 2, at + 2 + 12 * min(many, MOST_ENTRIES), 12):
            tag, kind = struct.unpack_from(order + "HH", exif, start)
            if tag == ORIENTATION:
                (turn,) = struct.unpack_from(
                    order + {1: "B", 3: "H", 4: "I"}[kind], exif, start + 8
                )
                return turn if 1 <= turn <= 8 else 1
    except (struct.error, KeyError):
        pass
    return 1


def _png(content: bytes) -> tuple[bytes, int]:
    parts, turn = [(0, 8)], 1
    for name, size, at in png_chunks(content):
        if name in PNG_PARTS:
            parts.append((at, at + 12 + size))
        elif name == b"eXIf":
            turn = rotation(content[at + 8 : at + 8 + size])
    return _joined(content, parts), turn


def _jpeg(content: bytes) -> tuple[bytes, int]:
    parts, turn, end = [(0, 2)], 0, 2
    for mark, start, end in jpeg_segments(content):
        if mark not in NOTES:
            parts.append((start, end))
        elif mark == 0xE1 and not turn and content[start + 4 : start + 10] == EXIF:
            turn = rotation(content[start + 4 : end])
    return _joined(content, [*parts, (end, len(content))]), turn or 1


def _tiff(content: bytes) -> tuple[bytes, int]:
    """Write a shorter table over the first one; its entries name values by their place."""
    table = tiff_table(content)
    if not table.entries:
        return content, 1
    tag_at = {at: struct.unpack_from(table.order + "H", content, at)[0] for at in table.entries}
    wide = table.entries.step
    kept = [content[at : at + wide] for at, tag in tag_at.items() if tag in TIFF_TAGS]
    count = struct.pack(table.order + table.count, len(kept))
    start = table.entries[0] - len(count)
    # the place of the next table
    end = table.entries[-1] + wide + struct.calcsize("=" + table.word)
    shorter = b"".join([count, *kept]).ljust(end - start, b"\0")
    turn = dict(table.values(content)).get(ORIENTATION, 1)
    return content[:start] + shorter + content[end:], turn if 1 <= turn <= 8 else 1


def _webp(content: bytes) -> tuple[bytes, int]:
    at = 12
    for _ in range(MOST_ENTRIES):
        if at + 8 > len(content):
            break
        name, size = struct.unpack_from("<4sI", content, at)
        if name == b"EXIF":
            return content, rotation(content[at + 8 : at + 8 + size])
        at += 8 + size + size % 2
    return content, 1


def _joined(content: bytes, parts: Iterable[tuple[int, int]]) -> bytes:
    parts = [(start, min(end, len(content))) for start, end in parts]
    if sum(end - start for start, end in parts) == len(content):
        return content
    seen = memoryview(content)
    return b"".join(seen[start:end] for start, end in parts)
