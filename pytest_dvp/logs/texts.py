"""Fields of words, such as COMPLETE_AUTO_DRIVE: which word each message or row holds."""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray

LONGEST = 60  # characters of a word, chosen: modes and gears are shorter, sentences and pictures longer
MOST = 40  # different words of a field, chosen: one with more is no mode, and its words would fill the memory


class Texts(NamedTuple):
    """codes (n,): the place in `words` of the word of each row, NaN where it holds none."""

    codes: FloatArray
    words: tuple[str, ...]


class Coder:
    """The words of a field, row by row. `full`: it holds other things than a few short words, and is no use."""

    def __init__(self, rows: int = 0) -> None:
        """rows: of them, before the first word, that hold none."""
        self.full = False
        self._codes = array("d", [np.nan]) * rows
        self._places: dict[str, float] = {}

    def __len__(self) -> int:
        return len(self._codes)

    def add(self, word: str | None) -> None:
        """The word of the next row; None or an empty one: none."""
        if not word:
            self._codes.append(np.nan)
            return
        code = self._places.setdefault(word, float(len(self._places)))
        self.full = self.full or len(word) > LONGEST or len(self._places) > MOST
        self._codes.append(code)

    def texts(self) -> Texts:
        """All rows."""
        return Texts(np.frombuffer(self._codes, dtype=np.float64), tuple(self._places))


def texts_of(words: Iterable[str | None]) -> Texts | None:
    """The words of a whole column; None if they are no few short ones."""
    coder = Coder()
    for word in words:
        coder.add(word)
        if coder.full:
            return None
    found = coder.texts()
    return found if found.words else None
