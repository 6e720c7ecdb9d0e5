"""How a campaign chooses and drives its points: what a command line, a pytest option or a script asks for."""

from __future__ import annotations

import dataclasses

from pytest_dvp.campaigns.campaign import KEEP
from pytest_dvp.campaigns.sampling import SAMPLES
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.spelling import unknown
from pytest_dvp.tuning.searchers import search_names

RUNS = 200
"""Drives where no number is asked for: less than a minute on two cores with the reference stack."""
RARE, HYPOTHESIS, BOUNDARY = "rare", "hypothesis", "boundary"
METHODS = (*SAMPLES, *search_names(), HYPOTHESIS, BOUNDARY, RARE)


@dataclasses.dataclass(frozen=True)
class Plan:
    """What is driven of each scenario.

    method  one of METHODS; runs: number of drives; keep: whose logs are kept, one of KEEP
    shard   part and number of parts of an even sample: (1, 1) for all of it
    """

    method: str = "sobol"
    runs: int = RUNS
    keep: str = KEEP[0]
    shard: tuple[int, int] = (1, 1)

    def checked(self, prefix: str = "--") -> Plan:
        """Itself. prefix: of the options in messages. Raises SettingError for a value that is not allowed."""
        for option, value, known in (("method", self.method, METHODS), ("keep-logs", self.keep, KEEP)):
            if value not in known:
                raise SettingError(f"{prefix}{option}: {unknown('value', value, known)}")
        if self.runs < 1:
            raise SettingError(f"{prefix}runs is {self.runs}, expected a whole number >= 1")
        if self.shard != (1, 1) and self.method not in SAMPLES:
            part, parts = self.shard
            raise SettingError(f"shard {part}/{parts}: only an even sample has parts: {', '.join(SAMPLES)}")
        return self


def shard_of(text: str | None, option: str = "--shard") -> tuple[int, int]:
    """Which part of how many: (1, 1) without the option. Raises SettingError for anything but I/N."""
    if text is None:
        return 1, 1
    words = text.split("/")
    if len(words) != 2 or not all(word.isascii() and word.isdigit() for word in words):
        raise SettingError(f"{option}: found {text!r}, expected I/N, as 2/4")
    part, parts = int(words[0]), int(words[1])
    if not 1 <= part <= parts:
        raise SettingError(f"{option}: found {text!r}, expected a part between 1 and {parts}")
    return part, parts
