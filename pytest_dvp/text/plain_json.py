"""Numbers and texts as JSON can hold them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any


def finite(value: Any) -> Any:
    """NaN and infinite as null, all the way down: JSON has no words for them. Texts as `spelled`."""
    if isinstance(value, Mapping):
        return {finite(key): finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [finite(entry) for entry in value]
    if isinstance(value, str):
        return spelled(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value


def spelled(text: str) -> str:
    """A file name that is no UTF-8 with those of its bytes by their numbers; any other text as it is."""
    return text if text.isascii() else text.encode("utf-8", "backslashreplace").decode()
