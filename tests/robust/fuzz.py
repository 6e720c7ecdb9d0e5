"""Counting mutants: how many, from which on, and where a nightly run that was interrupted goes on.

Mutant n of a test is made from the seed (test, n) alone, so any one can be made again. `DVP_FUZZ` sets their number
(the nightly target takes 100,000); then the number reached is kept in `runs/fuzz/NAME`, and the next run goes on there.
"""

from __future__ import annotations

import os
import random
from collections.abc import Iterator
from pathlib import Path

SEED = 20260101
KEEP_EVERY = 500  # mutants
FOLDER = Path(__file__).resolve().parents[2] / "runs" / "fuzz"


def numbers(name: str, default: int, *, folder: Path = FOLDER) -> Iterator[int]:
    """The numbers of the mutants to try, each once, also over several runs."""
    nightly = "DVP_FUZZ" in os.environ
    count = int(os.environ.get("DVP_FUZZ", default))
    place = folder / name
    first = int(place.read_text()) if nightly and place.exists() else 0
    for number in range(first, count):
        yield number
        if nightly and (number + 1) % KEEP_EVERY == 0:
            folder.mkdir(parents=True, exist_ok=True)
            place.write_text(str(number + 1))
    if nightly:
        place.unlink(missing_ok=True)  # the next run begins anew


def random_of(name: str, number: int) -> random.Random:
    """The generator of one mutant."""
    return random.Random(f"{SEED}:{name}:{number}")
