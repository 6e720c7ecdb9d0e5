"""Which effects a log could ever reveal, by what it holds and how it was driven. Placeholder numbers come below."""

from __future__ import annotations

import dataclasses

from pytest_dvp.log import Log


@dataclasses.dataclass(frozen=True)
class Excitation:
    pass


def excitation(log: Log) -> Excitation:
    return Excitation()
