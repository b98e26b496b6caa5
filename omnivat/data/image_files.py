"""Kind, size and memory cost of an image file, read from its header before decoding.

Only common kinds are parsed here, up to their first picture; rare kinds are identified and left to
their decoder. The number of parsed pieces is limited for any file.
"""

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from mmap import mmap

Content = bytes | mmap  # a file in memory, or mapped
MOST_PIECES = 20_000  # of one file; a camera's photo has tens, an 8-kilobyte PNG writer 2,500
MOST_TEXTS = 16  # compressed texts of a PNG; each may unpack to a megabyte
MOST_SCANS = 64  # of a progressive JPEG; usual programs write 10
MOST_SCANNED = 400_000_000  # samples of a JPEG times its scans
SIMPLE_PIXELS = 2_000_000
HEADER = 4096  # bytes that hold the header of a PPM
TIFF_TAGS = {  # size, packing and place of the pixels; colours; tables of packing
    *range(256, 260), 262, 266, 273, *range(277, 281), 284, 292, 293, 317, 320,
    *range(322, 326), 332, 338, 339, 347, *range(529, 533),
}  # fmt: skip
TIFF_CODES = {1: "B", 3: "H", 4: "I", 16: "Q"}

STARTS: tuple[tuple[str, bytes], ...] = (  # kind, start of its files; a dot is any byte
    ("PNG", rb"\x89PNG\r\n\x1a\n"),
    ("JPEG", rb"\xff\xd8\xff"),
    ("GIF", rb"GIF8[79]a"),
    ("BMP", rb"BM"),
    ("WEBP", rb"RIFF....WEBP"),
    ("TIFF", rb"II[*+]\x00|MM\x00[*+]"),
    ("QOI", rb"qoif"),
    ("JPEG2000", rb"\xff\x4f\xff\x51|\x00\x00\x00\x0cjP  \r\n\x87\n"),
    ("AVIF", rb"....ftypavi[fs]|....ftypmi[fa]1|....ftypmsf1"),
    ("PPM", rb"P[1-6fy0CUB]"),
)
COSTS = {"JPEG2000": 20, "AVIF": 10}  # bytes per pixel while decoding; others up to 6


class OddFileError(ValueError):
    """The file has an unusual structure; the message describes it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImageFile:
    """Facts about an image file from its header."""

    kind: str
    width: int = 0  # 0 if only the decoder can find it
    height: int = 0
    bytes_a_pixel: float = 6.0  # memory while decoding
    kept: float = 0.0  # of these, needed by a reduced decode, too
    usual: bool = True  # False for slow variants
    simple: bool = False  # decoding time depends on the pixels only

    @property
    def pixels(self) -> int:
        """The number of pixels."""
        return self.width * self.height

    def cost(self, scale: int = 1) -> int:
        """Return the memory for decoding, at 1/scale of the size if the kind allows it."""
        shrunk = scale**2 if self.kind == "JPEG" else 1
        return int(self.pixels * (self.kept + (self.bytes_a_pixel - self.kept) / shrunk))


def image_file(content: Content) -> ImageFile | None:
    """Return facts from the header of `content`; None for an unknown kind.

    Raises OddFileError for a truncated, damaged or excessively padded header.
    """
    kind = next((k for k, start in STARTS if re.match(start, content[:32], re.DOTALL)), None)
    if kind is None:
        return None
    found = ImageFile(kind=kind, bytes_a_pixel=COSTS.get(kind, 6), usual=kind in WALKS)
    try:
        return WALKS[kind](content, found) if found.usual else found
    except (struct.error, IndexError) as error:
        raise OddFileError("is cut short or damaged") from error


def _png(content: Content, facts: ImageFile) -> ImageFile:
    width, height, depth, colour, _, _, laced = struct.unpack_from(">IIBBBBB", content, 16)
    texts, large = 0, False
    for name, size, _ in png_chunks(content):
        texts += name in (b"zTXt", b"iTXt", b"iCCP")
        large = large or (name != b"IDAT" and size > 1_000_000)
    if texts > MOST_TEXTS:
        raise OddFileError(f"holds more than {MOST_TEXTS} compressed texts")
    each = {0: 2 if depth == 16 else 1, 3: 1}.get(colour, 4)
    each *= 2 if laced else 1  # seven passes take twice the time
    simple = not (laced or large or texts > 2) and width * height <= SIMPLE_PIXELS
    return replace(facts, width=width, height=height, bytes_a_pixel=each, simple=simple)


def png_chunks(content: Content) -> Iterator[tuple[bytes, int, int]]:
    """Yield name, size and place of each piece of a PNG."""
    at = 8
    for _ in range(MOST_PIECES):
        if at + 8 > len(content):
            return
        size, name = struct.unpack_from(">I4s", content, at)
        yield name, size, at
        at += 12 + size
    raise OddFileError(f"is cut into more than {MOST_PIECES:,} pieces")


def _jpeg(content: Content, facts: ImageFile) -> ImageFile:
    frame, at, process = b"", 2, 0
    for mark, start, at in jpeg_segments(content):
        if mark in (0xC0, 0xC1, 0xC2, 0xC9, 0xCA):
            process, frame = mark, content[start + 4 : at]
    if not frame:
        raise OddFileError("is cut short or damaged")
    height, width, count = struct.unpack_from(">xHHB", frame)
    shares = [(frame[7 + 3 * k] >> 4, frame[7 + 3 * k] & 15) for k in range(count)]
    samples = sum(h * v for h, v in shares) / (max(h * v for h, v in shares) or 1)
    whole = process in (0xC2, 0xCA) or content[at + 4] < count  # coefficients of all the picture
    scans = sum(1 for _ in islice(re.finditer(rb"\xff\xda", content), MOST_SCANS + 1))
    if whole and (scans > MOST_SCANS or width * height * samples * scans > MOST_SCANNED):
        raise OddFileError(f"is a JPEG of {width} × {height} pixels drawn in {scans} passes")
    kept = 2 * samples if whole else 0.0
    simple = not whole and process in (0xC0, 0xC1) and width * height <= SIMPLE_PIXELS
    facts = replace(facts, usual=process in (0xC0, 0xC1, 0xC2), simple=simple, kept=kept)
    return replace(facts, width=width, height=height, bytes_a_pixel=kept + (1 if count == 1 else 4))


def jpeg_segments(content: Content) -> Iterator[tuple[int, int, int]]:
    """Yield mark, start and end of each segment of a JPEG up to its first scan."""
    at = 2
    for _ in range(MOST_PIECES // 10):
        if content[at] == 0xFF and content[at + 1] == 0xFF:  # fill bytes: go to the last one
            end = re.compile(rb"[^\xff]").search(content, at)
            at = end.start() - 1 if end else len(content)
        first, mark, size = struct.unpack_from(">BBH", content, at)
        if first != 0xFF:
            raise OddFileError("is cut short or damaged")
        if mark == 0xDA:
            return
        yield mark, at, at + 2 + size
        at += 2 + size
    raise OddFileError(f"has more than {MOST_PIECES // 10:,} pieces before its picture")


def _gif(content: Content, facts: ImageFile) -> ImageFile:
    width, height, flags = struct.unpack_from("<HHB", content, 6)
    at, pieces = 13 + (3 * 2 ** ((flags & 7) + 1) if flags & 0x80 else 0), 0
    while content[at] == 0x21:  # an extension: a label, then blocks up to an empty one
        at += 2
        while content[at]:
            at += 1 + content[at]
            pieces += 1
            if pieces > MOST_PIECES // 20:
                raise OddFileError("has too much before its first picture")
        at += 1
    left, top, wide, high = struct.unpack_from("<xHHHH", content, at)
    width, height = max(width, left + wide), max(height, top + high)
    return replace(facts, width=width, height=height, bytes_a_pixel=3)


def _bmp(content: Content, facts: ImageFile) -> ImageFile:
    (size,) = struct.unpack_from("<I", content, 14)
    fields = struct.unpack_from("<HHHH" if size == 12 else "<iiHHI", content, 18)
    width, height, _, bits, packed = (*fields, 0)[:5]
    each, usual = 1 if bits <= 8 else 4, packed in (0, 3)  # run lengths are unpacked slowly
    return replace(facts, width=abs(width), height=abs(height), bytes_a_pixel=each, usual=usual)


def _webp(content: Content, facts: ImageFile) -> ImageFile:
    first = content[12:16]
    if first == b"VP8X":
        width, height = (1 + int.from_bytes(content[k : k + 3], "little") for k in (24, 27))
    elif first == b"VP8L":
        (packed,) = struct.unpack_from("<I", content, 21)
        width, height = 1 + (packed & 0x3FFF), 1 + ((packed >> 14) & 0x3FFF)
    else:
        width, height = (side & 0x3FFF for side in struct.unpack_from("<HH", content, 26))
    return replace(facts, width=width, height=height, bytes_a_pixel=16)  # measured


def _tiff(content: Content, facts: ImageFile) -> ImageFile:
    tags = dict(tiff_table(content).values(content))
    width, height = tags.get(256, 0), tags.get(257, 0)
    bits, samples = tags.get(258, 1), tags.get(277, 1)
    each = 4 if samples > 1 else {8: 1, 16: 2}.get(bits, 1 if bits < 8 else 4)
    packed = tags.get(259, 1)
    piece = tags.get(322, width) * tags.get(323, min(tags.get(278, height), height))
    unpacked = 0.0 if packed == 1 else piece * samples * bits / 8
    needed, usual = each + unpacked / max(1, width * height), packed in (1, 5, 8, 32773, 32946)
    return replace(facts, width=width, height=height, bytes_a_pixel=needed, usual=usual)


@dataclass(frozen=True, slots=True, kw_only=True)
class TiffTable:
    """The table of a TIFF's first picture: byte order, codes of its numbers, place of each
    entry.
    """

    order: str
    count: str
    entry: str
    word: str
    entries: range

    def values(self, content: Content) -> Iterator[tuple[int, int]]:
        """Yield each tag with its first value if that is in the table."""
        for at in self.entries:
            tag, kind, number = struct.unpack_from(self.order + self.entry, content, at)
            if tag in TIFF_TAGS and number > 65_536:
                raise OddFileError(f"has an entry of {number} values")
            code, place = TIFF_CODES.get(kind), at + struct.calcsize("=" + self.entry)
            inside = code and number * struct.calcsize(code) <= struct.calcsize("=" + self.word)
            if code and (inside or tag == 258):
                if not inside:
                    (place,) = struct.unpack_from(self.order + self.word, content, place)
                yield tag, struct.unpack_from(self.order + code, content, place)[0]


def tiff_table(content: Content) -> TiffTable:
    """Return the table of a TIFF's first picture."""
    order = "<" if content[:2] == b"II" else ">"
    big = content[2:4] in (b"+\0", b"\0+")
    count, entry, word = ("Q", "HHQ", "Q") if big else ("H", "HHI", "I")
    (at,) = struct.unpack_from(order + word, content, 8 if big else 4)
    (many,) = struct.unpack_from(order + count, content, at)
    if many > 512:
        raise OddFileError(f"has a table of {many} entries")
    width, first = struct.calcsize("=" + entry + word), at + struct.calcsize("=" + count)
    entries = range(first, first + many * width, width)
    return TiffTable(order=order, count=count, entry=entry, word=word, entries=entries)


def _ppm(content: Content, facts: ImageFile) -> ImageFile:
    """Parse a header of three or four words; comments of any length may be between them."""
    if len(re.sub(rb"#[^\r\n]*[\r\n]", b" ", content[:HEADER]).split(None, 3)) < 3:
        raise OddFileError(f"has no header in its first {HEADER} bytes")
    return replace(facts, usual=False)


WALKS = {
    "PNG": _png,
    "JPEG": _jpeg,
    "GIF": _gif,
    "BMP": _bmp,
    "WEBP": _webp,
    "TIFF": _tiff,
    "PPM": _ppm,
}
