"""Small worlds for the harness: a straight road, an ego, and stacks that do one thing."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import pytest

from tests.plugin.conftest import XOSC, write_scenario
from vehicle.messages import Command, Detection, FloatArray, Observation

Tick = Callable[[Observation], Command]


def coast(observation: Observation) -> Command:
    return Command(observation.t, 0.0, 0.0, 0.0, 0.0)


@dataclasses.dataclass
class OneTrick:
    """A driving stack made of one function; remembers what it saw."""

    trick: Tick
    seen: list[Observation] = dataclasses.field(default_factory=list)
    trace: Mapping[str, float] = dataclasses.field(default_factory=dict)
    path: FloatArray | None = None
    detections: Sequence[Detection] = ()

    def tick(self, observation: Observation) -> Command:
        self.seen.append(observation)
        return self.trick(observation)

    def __call__(self, *_: object) -> OneTrick:
        return self


@pytest.fixture
def scenario(tmp_path: Path) -> Callable[..., Path]:
    """Writes the small scenario with parts of its text replaced."""

    def write(*replacements: tuple[str, str], name: str = "x.xosc") -> Path:
        text = XOSC
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new)
        return write_scenario(tmp_path, name, text)

    return write
