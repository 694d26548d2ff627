"""Check that a file is a complete picture."""

import struct
import zlib
from pathlib import Path

SIGNATURE = b"\x89PNG\r\n\x1a\n"
UNIFORM = 8  # largest number of byte values in a picture of one colour: the colour's and the row filters'


def is_complete_png(path: Path) -> bool:
    """Return whether `path` is a PNG with every chunk intact and more than one colour in it."""
    try:
        content = path.read_bytes()
    except OSError:
        return False
    chunks = _chunks(content)
    if not chunks or chunks[-1][0] != b"IEND":
        return False
    try:
        pixels = zlib.decompress(b"".join(data for kind, data in chunks if kind == b"IDAT"))
    except zlib.error:
        return False
    return len(set(pixels)) > UNIFORM


def _chunks(content: bytes) -> list[tuple[bytes, bytes]]:
    """Return kind and data of the chunks; none if one is damaged."""
    if not content.startswith(SIGNATURE):
        return []
    chunks, start = [], len(SIGNATURE)
    while start + 12 <= len(content):
        (length,) = struct.unpack(">I", content[start : start + 4])
        kind, end = content[start + 4 : start + 8], start + 8 + length
        if content[end : end + 4] != struct.pack(">I", zlib.crc32(content[start + 4 : end])):
            return []
        chunks.append((kind, content[start + 8 : end]))
        start = end + 4
    return chunks
