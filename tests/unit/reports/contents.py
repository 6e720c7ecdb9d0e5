"""The data of a page as its scripts read them; `contents()` of templates/theme.js in Python."""

from __future__ import annotations

import base64
import gzip
import itertools
import json
import re
from typing import Any


def contents(page: str) -> Any:
    """Data of a page's text, its long lists put back."""
    block = re.search(r'id="data">(.*?)</script>', page, re.DOTALL)
    assert block is not None
    return filled(json.loads(block[1]))


def filled(data: dict[str, Any]) -> Any:
    """Compact data with its long lists put back."""
    packed = data.pop("@arrays", None)
    return data if packed is None else _filled(data, [_list(each) for each in json.loads(_unpacked(packed))])


def _unpacked(text: str) -> bytes:
    return gzip.decompress(base64.b64decode(text))


def _list(written: Any) -> Any:
    if isinstance(written, list):
        return written
    sums = itertools.accumulate(step or 0 for step in written["steps"])
    scale = 10.0 ** written["digits"]
    return [None if step is None else whole / scale for step, whole in zip(written["steps"], sums, strict=True)]


def _filled(value: Any, lists: list[Any]) -> Any:
    if isinstance(value, dict):
        return lists[value["@array"]] if "@array" in value else {k: _filled(v, lists) for k, v in value.items()}
    return [_filled(each, lists) for each in value] if isinstance(value, list) else value
