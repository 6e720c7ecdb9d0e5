"""Checksums that drive-by-wire frames are protected with: one byte over a frame's identifier and its other bytes."""

from __future__ import annotations

from collections.abc import Callable, Mapping

POLYNOMIAL = 0x1D  # x^8 + x^4 + x^3 + x^2 + 1, SAE J1850


def _table() -> tuple[int, ...]:
    rows = []
    for value in range(256):
        for _ in range(8):
            value = (value << 1) ^ POLYNOMIAL if value & 0x80 else value << 1
        rows.append(value & 0xFF)
    return tuple(rows)


_TABLE = _table()


def crc8_j1850(data: bytes) -> int:
    """CRC-8 of SAE J1850: start 0xFF, result inverted. Source: AUTOSAR Specification of CRC Routines, 7.2.1.2."""
    crc = 0xFF
    for byte in data:
        crc = _TABLE[crc ^ byte]
    return crc ^ 0xFF


def xor8(data: bytes) -> int:
    """All bytes, exclusive or."""
    result = 0
    for byte in data:
        result ^= byte
    return result


def sum8(data: bytes) -> int:
    """Sum of all bytes, its low eight bits."""
    return sum(data) & 0xFF


CHECKSUMS: Mapping[str, Callable[[bytes], int]] = {"crc8_j1850": crc8_j1850, "xor": xor8, "sum": sum8}
"""By the name that a signal map gives. Argument: identifier, low byte first, in two bytes (four if extended), then the
frame's bytes without that of the checksum."""
