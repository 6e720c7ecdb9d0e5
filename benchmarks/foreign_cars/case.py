"""Generated cases: which car, which hidden effect, how strong. Nothing here runs a simulation.

The seed is that of a commit (its first eight hexadecimal digits): the one at which the rule of the diagnosis stood.
"""

from __future__ import annotations

import itertools
import zlib
from dataclasses import dataclass
from typing import Literal

import numpy as np

from benchmarks.foreign_cars.car import CARS
from benchmarks.foreign_cars.fleet import FLEET
from benchmarks.foreign_cars.hidden import RANGES, drawn

Category = Literal["bare", "null", "single"]
NOISES = ("low", "mid", "high")


@dataclass(frozen=True)
class Case:
    """One question. bare: the car as it is, from its data sheet; null: again, from a twin that learnt it; single: the
    same with one hidden effect."""

    category: Category
    car: str
    name: str
    number: int
    noise: str
    seed: str

    @property
    def key(self) -> str:
        """Unique among the cases of a seed."""
        return "/".join(part for part in (self.category, self.car, self.name, str(self.number), self.noise) if part)

    @property
    def rng(self) -> np.random.Generator:
        """Its dice: same case, same values."""
        return np.random.default_rng([int(self.seed, 16), zlib.crc32(self.key.encode())])

    @property
    def drive_seed(self) -> int:
        """Seed of driver and noise."""
        return int(self.rng.integers(1, 1_000_000))

    @property
    def truth(self) -> dict[str, dict[str, float]]:
        """What is hidden."""
        rng = self.rng
        rng.integers(1, 1_000_000)  # the drive's
        return {self.name: drawn(self.name, rng)} if self.name else {}


def cases(seed: str) -> list[Case]:
    """All, in an order of which every beginning is a fair sample: bare cars, then nulls and singles by turns. The
    van is asked bare only."""
    order = np.random.default_rng(int(seed, 16))
    bare = [Case("bare", car, "", 0, "mid", seed) for car in FLEET]
    singles: list[Case] = []
    for number in range(4):
        pairs = list(itertools.product(RANGES, CARS))
        for k in order.permutation(len(pairs)):
            name, car = pairs[k]
            singles.append(Case("single", car, name, number, NOISES[(k + number) % 3], seed))
    nulls = [Case("null", car, "", n, NOISES[n % 3], seed) for n in range(24) for car in CARS]
    found = list(bare)
    while singles or nulls:
        found += singles[:4] + nulls[:1]
        singles, nulls = singles[4:], nulls[1:]
    return found
