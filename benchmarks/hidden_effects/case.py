"""Cases: what is hidden, in which car, under which noise. Drawn from seeds; nothing here runs a simulation."""

from __future__ import annotations

import itertools
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from benchmarks.hidden_effects.ranges import LATER, PERCEPTION, RANGES, tied
from tests.truth.effects import OUTSIDE

Category = Literal[
    "single", "null", "pair", "triple", "outside", "urban", "dirty", "surrogate", "multibody", "ablation", "perception"
]
NOISES = ("low", "mid", "high")
# what a log may have and still be diagnosed, and what no diagnosis may build on
HARMLESS = ("jitter", "mixed_rates", "quantised", "dropouts")
WRONG = ("degrees_as_radians", "kmh_as_mps", "sign_flip", "axis_swap", "clock_offset")
CARS = ("ford_escort", "bmw_320i", "vw_vanagon")
ON_TOP = (
    "steer_delay",
    "drive_delay",
    "drive_gain",
    "brake_gain",
    "steer_ratio",
    "steer_asymmetry",
    "steer_offset",
    "wheel_radius",
    "gyro_bias",
    "accelerometer_bias",
    "heading_bias",
    "yaw_rate_latency",
    "gnss_latency",
    "gnss_lever_arm",
    "imu_misalignment",
)
"""Effects that can be put on a recording. Not pitch and roll: those cars pitch and roll by themselves."""


@dataclass(frozen=True)
class Case:
    """One question to the diagnosis. `names`: the hidden effects; values are drawn from `key` when the case runs."""

    category: Category
    names: tuple[str, ...]
    seed: int
    noise: str
    dirt: str = ""
    car: str = ""
    off: str = ""
    """Ablation: the effect that is drawn like the others and then switched off."""
    base_seed: int = 1000

    @property
    def key(self) -> str:
        """Its name, unique in the matrix."""
        parts = [self.category, "+".join(self.names) or "nothing", self.car, self.dirt, f"s{self.seed}", self.noise]
        return "/".join(part for part in parts if part)

    @property
    def drawn_as(self) -> str:
        """The key that its values are drawn from: an ablation has those of its pair or triple."""
        if self.category == "ablation":
            return replace(self, category="triple" if len(self.names) == 3 else "pair", off="").key
        return self.key

    def rng(self) -> np.random.Generator:
        """Its dice: same case, same values."""
        return np.random.default_rng([self.base_seed, zlib.crc32(self.drawn_as.encode())])

    @property
    def truth(self) -> tuple[str, ...]:
        """The effects that are really there."""
        return tuple(name for name in self.names if name != self.off)

    @property
    def log_seed(self) -> int:
        """Seed of drive and noise."""
        return (self.base_seed * 1009 + zlib.crc32(self.drawn_as.encode())) % 1_000_003


def _singles(effects: Sequence[str], seeds: int) -> Iterable[Case]:
    """Round after round over all effects; an effect meets its seeds and noise levels in an order of its own."""
    grid = list(itertools.product(range(seeds), NOISES))
    for turn in range(len(grid)):
        for name in _shuffled(effects, turn):
            seed, noise = grid[(7 * turn + zlib.crc32(name.encode())) % len(grid)]
            yield Case("single", (name,), seed, noise)


def _shuffled(names: Sequence[str], turn: int) -> list[str]:
    first = [name for name in names if name not in LATER]
    order = np.random.default_rng([turn, 3]).permutation(len(first))
    return [first[k] for k in order] + [name for name in names if name in LATER]


def _mixtures(count: int, size: int) -> Iterable[Case]:
    rng = np.random.default_rng([size, 11])
    pool = [name for name in RANGES if name not in ("speed_controller", *LATER)]
    found: set[frozenset[str]] = set()
    while len(found) < count:
        names = tuple(pool[k] for k in rng.choice(len(pool), size, replace=False))
        # load transfer alone can hardly be seen anywhere in its range: the mixture would be no mixture
        if tied(names) or "load_transfer" in names or frozenset(names) in found:
            continue
        found.add(frozenset(names))
        category: Category = "pair" if size == 2 else "triple"
        yield Case(category, names, len(found) - 1, NOISES[len(found) % 3])


def strata() -> dict[str, list[Case]]:
    """All cases by category; any beginning of a list is a fair sample of it."""
    effects = tuple(RANGES)
    pairs, triples = list(_mixtures(20, 2)), list(_mixtures(10, 3))
    on_top = _shuffled(ON_TOP, 5)
    return {
        "single": list(_singles(effects, 5)),
        "null": [Case("null", (), seed, NOISES[seed % 3]) for seed in range(99)],
        "pair": pairs,
        "triple": triples,
        "outside": [
            Case("outside", (name,), seed, NOISES[(seed + k) % 3])
            for seed in range(3)
            for k, name in enumerate(_shuffled(OUTSIDE, seed))
        ],
        "urban": [
            Case("urban", (name,), seed, NOISES[(seed + k) % 3])
            for seed in range(3)
            for k, name in enumerate(_shuffled(effects, seed + 50))
        ],
        "dirty": [
            Case("dirty", (name,), seed, "mid", dirt=dirt)
            for seed, name in enumerate(("steer_delay", "drive_gain", "rolling_resistance", "steer_ratio"))
            for dirt in (*HARMLESS, *WRONG)
        ],
        "surrogate": [Case("surrogate", (), seed, noise) for seed, noise in enumerate(NOISES)]
        + [Case("surrogate", (on_top[k % len(on_top)],), k, NOISES[k % 3]) for k in range(40)],
        "multibody": [Case("multibody", (), 0, "mid", car=car) for car in CARS]
        + [Case("multibody", (on_top[k % len(on_top)],), k, NOISES[k // 3 % 3], car=CARS[k % 3]) for k in range(40)],
        "ablation": [replace(case, category="ablation", off=case.names[0]) for case in (*pairs, *triples)],
        "perception": [Case("perception", (name,), seed, NOISES[seed % 3]) for seed in range(5) for name in PERCEPTION],
    }


def cases(base_seed: int = 1000) -> list[Case]:
    """The whole matrix, in an order of which every beginning is a stratified sample.

    The share of a category grows with the root of its size, so that small ones show in short runs.
    """
    placed = [
        ((k + 0.5) / len(members) ** 0.5, number, replace(case, base_seed=base_seed))
        for number, members in enumerate(strata().values())
        for k, case in enumerate(members)
    ]
    return [case for _, _, case in sorted(placed, key=lambda entry: entry[:2])]
