"""Mutated scenario files: whatever comes, reading ends in a model or in findings.

`DVP_FUZZ` sets the number of mutations (default 2,000; the nightly target takes 100,000).
"""

from __future__ import annotations

import os
import random
import re
from pathlib import Path

import pytest

from openscenario.findings import Finding, ScenarioError
from openscenario.read import check_scenario, read_scenario
from openscenario.write import write_scenario
from openscenario.xml import parse_xml

COUNT = int(os.environ.get("DVP_FUZZ", "2000"))
SEED = 20260101
LARGEST = 30_000  # bytes; larger files say nothing new and take longer
WORDS = (
    b"NaN",
    b"-1",
    b"1e308",
    b"",
    b"$x",
    b"${1/0}",
    b"${((((",
    b"${" + b"(" * 3000,
    b"true",
    b"\xff",
    b"\x00",
    b"&lt;",
    b"&foo;",
    b'"',
    b"<",
    b">",
    b"/>",
    b"<Position>",
    b"../../etc/passwd",
    b"%2f",
    b"9" * 400,
    b"\xef\xbb\xbf",
    b"<![CDATA[",
    b"<!DOCTYPE a>",
    b'xmlns="http://x"',
)


def mutate(data: bytes, rng: random.Random) -> bytes:
    """A few values, tags or bytes replaced, inserted, doubled or removed."""
    result = bytearray(data)
    by_syntax = rng.random() < 0.6
    for _ in range(rng.randint(1, 6)):
        if by_syntax:
            places = list(re.finditer(rb'"[^"]*"' if rng.random() < 0.6 else rb"</?\w+", bytes(result)))
            if not places:
                break
            target, source = rng.choice(places), rng.choice(places)
            new = b'"' + rng.choice(WORDS) + b'"' if rng.random() < 0.5 else source.group()
            result[target.start() : target.end()] = new
            continue
        at, kind = rng.randrange(len(result) or 1), rng.random()
        if kind < 0.3:
            result[at : at + 1] = bytes([rng.randrange(256)])
        elif kind < 0.6:
            result[at:at] = rng.choice(WORDS)
        elif kind < 0.8:
            del result[at : at + rng.randint(1, 200)]
        else:
            start = rng.randrange(len(result) or 1)
            result[at:at] = result[start : start + rng.randint(1, 400)]
    return bytes(result)


def test_mutated_files_raise_nothing_but_findings(shared_dir: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    corpus = shared_dir / "openscenario" / "corpus"
    files = [file for file in sorted(corpus.rglob("*.xosc")) if file.stat().st_size <= LARGEST]
    rng = random.Random(SEED)
    for number in range(COUNT):
        file = rng.choice(files)
        data = mutate(file.read_bytes(), rng)
        # the mutated bytes in place of the file's, so that its road and catalogues are found
        monkeypatch.setattr("openscenario.read.scenario.read_xml", lambda path, data=data: parse_xml(data, str(path)))
        try:
            findings = check_scenario(file, library=[corpus])
        except Exception as error:
            raise AssertionError(f"mutation {number} of {file} (seed {SEED})") from error
        assert all(isinstance(finding, Finding) for finding in findings)


def test_what_is_read_from_a_mutated_file_is_written_and_reads_back(
    shared_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    corpus = shared_dir / "openscenario" / "corpus"
    files = [file for file in sorted(corpus.rglob("*.xosc")) if file.stat().st_size <= LARGEST]
    rng = random.Random(SEED + 1)
    survivors = 0
    for _ in range(COUNT // 10):
        file = rng.choice(files)
        data = mutate(file.read_bytes(), rng)
        with monkeypatch.context() as patched:
            patched.setattr("openscenario.read.scenario.read_xml", lambda path, data=data: parse_xml(data, str(path)))
            try:
                scenario = read_scenario(file, library=[corpus])
            except ScenarioError:
                continue
        survivors += 1
        write_scenario(scenario, tmp_path / "copy.xosc")
        assert read_scenario(tmp_path / "copy.xosc", library=[corpus]) == scenario
    assert survivors > 0
