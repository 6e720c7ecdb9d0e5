"""Random damage to a road file yields findings or a network that can be used, and nothing else."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from fuzz import numbers, random_of

from openscenario.findings import ScenarioError
from openscenario.road.network import RoadNetwork, load_network

MUTANTS = 150
LARGEST = 60_000  # bytes
VALUES = [b"nan", b"inf", b"-1", b"0", b"1e300", b"1e-300", b"1e9", b"word", b"", b"99999999999999999999", b"end", b"5"]


def mutant(text: bytes, rng: random.Random) -> bytes:
    """The text with one to twenty attributes, bytes, lines or elements changed."""
    data = bytearray(text)
    for _ in range(rng.choice([1, 1, 2, 5, 20])):
        kind = rng.random()
        if kind < 0.6:
            place = rng.choice(list(re.finditer(rb'="([^"<>]*)"', data)))
            data[place.start(1) : place.end(1)] = rng.choice(VALUES)
        elif kind < 0.7:
            data[rng.randrange(len(data))] = rng.randrange(256)
        elif kind < 0.85:
            lines = bytes(data).split(b"\n")
            del lines[rng.randrange(len(lines))]
            data = bytearray(b"\n".join(lines))
        elif places := list(re.finditer(rb"<\w+[^<>]*/>", data)):
            place = rng.choice(places)
            del data[place.start() : place.end()]
    return bytes(data)


def use(net: RoadNetwork) -> None:
    """Every kind of question, on every road."""
    for road in net.roads.values():
        for lane in (-1, 1):
            if net.lane(road.id, lane, 0.0) is None:
                continue
            pose = net.lane_pose(road.id, lane, 0.0)
            there = net.locate(pose.x, pose.y, h=pose.h)
            net.advance(there, 20.0)
            net.advance(there, -20.0)
            net.lane_successors(road.id, lane)
    net.boundaries(5.0)
    net.lane_graph()
    assert net.crosswalks is not None


@pytest.fixture
def samples(request: pytest.FixtureRequest, scenarios_dir: Path) -> list[Path]:
    """Files to mutate: the shipped road, and small ones of the public corpus if it is there."""
    try:
        corpus = request.getfixturevalue("shared_dir") / "openscenario" / "corpus"
    except pytest.skip.Exception:
        return [scenarios_dir / "urban.xodr"]
    small = [path for path in sorted(corpus.rglob("*.xodr")) if path.stat().st_size <= LARGEST]
    return [scenarios_dir / "urban.xodr", *small]


def test_damaged_road_files(tmp_path: Path, samples: list[Path]) -> None:
    path = tmp_path / "mutant.xodr"
    refused = tried = 0
    for number in numbers("roads", MUTANTS):
        rng = random_of("roads", number)
        file = rng.choice(samples)
        path.write_bytes(mutant(file.read_bytes(), rng))
        tried += 1
        try:
            use(load_network(path))
        except ScenarioError as error:
            refused += len(error.findings) > 0
        except Exception as error:
            raise AssertionError(f"mutation {number} of {file}") from error
    assert tried == 0 or 0 < refused < tried
