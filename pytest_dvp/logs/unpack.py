"""Unpacking of a block that somebody else compressed: never to more bytes than the caller allows."""

from __future__ import annotations

import bz2

ZSTD_WINDOW = 1 << 27
"""Bytes of memory that a zstd frame may ask for (zstd's own limit of a decoder, --long=27)."""


class UnpackError(ValueError):
    """A block is damaged, or is compressed in a way that is not known."""


class TooLargeError(UnpackError):
    """A block unpacks to more than is allowed."""


def unpack(name: str, packed: bytes, most: int) -> bytes:
    """The content of a block of `lz4` (frame), `zstd`, `bz2`, or "" for one that is not compressed.

    Raises TooLargeError, before memory is taken, for more than `most` bytes; UnpackError for a damaged block.
    """
    try:
        content, whole = _unpacked(name, packed, most)
    except UnpackError:
        raise
    except Exception as error:  # each library has errors of its own; whatever it says, the block is lost
        raise UnpackError(f"a block of {name} is damaged: {error}") from None
    if len(content) > most:
        raise TooLargeError(f"a block of {name} unpacks to more than {most} bytes")
    if not whole:
        raise UnpackError(f"a block of {name} is cut")
    return content


def _unpacked(name: str, packed: bytes, most: int) -> tuple[bytes, bool]:
    """At most one byte more than is allowed, and whether that is all."""
    if name == "":
        return packed, True
    if name == "lz4":
        from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

        lz4 = LZ4FrameDecompressor()
        return bytes(lz4.decompress(packed, max_length=most + 1)), bool(lz4.eof)
    if name == "bz2":
        decompressor = bz2.BZ2Decompressor()
        return decompressor.decompress(packed, max_length=most + 1), decompressor.eof
    if name == "zstd":
        import zstandard

        if zstandard.frame_content_size(packed) > most:  # a frame is taken at its word
            raise TooLargeError(f"a block of zstd unpacks to more than {most} bytes")
        return zstandard.ZstdDecompressor().decompress(packed, max_output_size=most + 1), True
    raise UnpackError(f"compression {name!r} is not known; allowed: lz4, zstd, bz2")
