"""Assignments: what `--set` changes, sorted by whose parameter it is."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

from pytest_dvp.text.errors import SettingError


@dataclasses.dataclass(frozen=True)
class Assignments:
    """`--set` sorted by what it changes: scenario parameters, P of the ADS, S of the simulator."""

    scenario: Mapping[str, str] = dataclasses.field(default_factory=dict)
    P: Mapping[str, str] = dataclasses.field(default_factory=dict)
    S: Mapping[str, str] = dataclasses.field(default_factory=dict)

    def words(self) -> list[str]:
        """The assignments as the command line takes them."""
        return [
            *(f"{name}={value}" for name, value in self.scenario.items()),
            *(f"P.{name}={value}" for name, value in self.P.items()),
            *(f"S.{name}={value}" for name, value in self.S.items()),
        ]


def parse_assignments(words: Sequence[str], origin: str = "--set") -> Assignments:
    """Sort `NAME=VALUE`, `P.NAME=VALUE`, `S.NAME=VALUE`; the last of two for one name counts.

    Raises SettingError for a word without `=` or without a name.
    """
    sorted_words: dict[str, dict[str, str]] = {"": {}, "P": {}, "S": {}}
    for word in words:
        name, equals, value = word.partition("=")
        name, value = name.strip(), value.strip()
        if not equals or not name or not value:
            raise SettingError(f"{origin} {word!r}: expected NAME=VALUE, P.NAME=VALUE or S.NAME=VALUE")
        group, dot, rest = name.partition(".")
        if dot and group in ("P", "S") and rest:
            sorted_words[group][rest] = value
        else:
            sorted_words[""][name] = value
    return Assignments(scenario=sorted_words[""], P=sorted_words["P"], S=sorted_words["S"])
