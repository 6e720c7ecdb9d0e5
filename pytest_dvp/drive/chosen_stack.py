"""A driving stack that was chosen."""

from __future__ import annotations

import dataclasses
from typing import Any


@dataclasses.dataclass(frozen=True)
class Ads:
    """A driving stack that was chosen.

    name     for people and the log, without a path
    word     what `--ads` takes to choose it again; None if no command line can name it
    factory  class or function that makes it, or the stack itself
    """

    name: str
    word: str | None
    factory: Any
