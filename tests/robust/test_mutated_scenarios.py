"""Mutated scenario files: whatever comes, reading ends in a model or in findings.

`DVP_FUZZ` sets the number of mutations (default 400; the nightly target takes 100,000); see `fuzz.py`.
"""

from __future__ import annotations

import os
import random
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from fuzz import numbers, random_of

from openscenario.findings import Finding, ScenarioError
from openscenario.read import check_scenario, read_scenario
from openscenario.write import write_scenario
from openscenario.xml import Document, Node, parse_xml, read_xml, render
from scenarios import __file__ as scenarios_file

COUNT = 400
SHIPPED = Path(scenarios_file).parent
LARGEST = 30_000  # bytes; larger files say nothing new and take longer
DISTRIBUTION = """<OpenSCENARIO>
<FileHeader revMajor="1" revMinor="3" date="2026-01-01T00:00:00" description="" author=""/>
<ParameterValueDistribution><ScenarioFile filepath="{scenario}"/>
<Stochastic numberOfTestRuns="9" randomSeed="1.5">
<StochasticDistribution parameterName="a"><NormalDistribution expectedValue="1" variance="2">
<Range lowerLimit="-1" upperLimit="2"/></NormalDistribution></StochasticDistribution>
<StochasticDistribution parameterName="b">
<LogNormalDistribution expectedValue="1" variance="2"/></StochasticDistribution>
<StochasticDistribution parameterName="c"><PoissonDistribution expectedValue="30"/></StochasticDistribution>
<StochasticDistribution parameterName="d"><Histogram><Bin weight="1"><Range lowerLimit="1" upperLimit="2"/></Bin>
</Histogram></StochasticDistribution>
<StochasticDistribution parameterName="e"><ProbabilityDistributionSet><Element value="x" weight="0.5"/>
</ProbabilityDistributionSet></StochasticDistribution>
<StochasticDistribution parameterName="f"><UserDefinedDistribution type="u">x</UserDefinedDistribution>
</StochasticDistribution></Stochastic>
<Deterministic><DeterministicSingleParameterDistribution parameterName="g"><DistributionRange stepWidth="0.1">
<Range lowerLimit="0" upperLimit="1"/></DistributionRange></DeterministicSingleParameterDistribution>
<DeterministicMultiParameterDistribution><ValueSetDistribution><ParameterValueSet>
<ParameterAssignment parameterRef="h" value="1"/></ParameterValueSet></ValueSetDistribution>
</DeterministicMultiParameterDistribution></Deterministic>
</ParameterValueDistribution></OpenSCENARIO>
"""
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


def mutate_tree(data: bytes, rng: random.Random) -> bytes:
    """A few elements doubled, dropped, moved, renamed or emptied, attributes swapped: well-formed, and wrong."""
    root = parse_xml(data, "").root
    for _ in range(rng.randint(1, 4)):
        nodes = [node for node in root.walk() if node.parent is not None]
        if not nodes:
            break
        node, other = rng.choice(nodes), rng.choice(nodes)
        siblings = node.parent.children if node.parent is not None else []
        match rng.randrange(6):
            case 0:
                siblings.insert(rng.randint(0, len(siblings)), node)
            case 1:
                siblings.remove(node)
            case 2:
                other.children.append(Node(node.tag, 0, dict(node.attributes), node.text, other))
            case 3:
                node.tag = other.tag
            case 4:
                node.children = []
            case 5:
                node.attributes, other.attributes = other.attributes, node.attributes
    return render(root).encode()


@pytest.fixture
def samples(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[list[Path], list[Path]]:
    """Files to mutate, and libraries: the shipped scenarios, a distribution, and the public corpus if it is there."""
    varied = os.path.relpath(next(SHIPPED.glob("*.xosc")), tmp_path)
    (tmp_path / "distribution.xosc").write_text(DISTRIBUTION.format(scenario=varied))
    files, library = [tmp_path / "distribution.xosc", *sorted(SHIPPED.rglob("*.xosc"))], [SHIPPED]
    try:
        corpus = request.getfixturevalue("shared_dir") / "openscenario" / "corpus"
    except pytest.skip.Exception:
        return files, library
    return [*files, *sorted(corpus.rglob("*.xosc"))], [*library, corpus]


def mutants(files: list[Path], name: str, count: int) -> Iterator[tuple[int, Path, bytes]]:
    small = [file for file in files if file.stat().st_size <= LARGEST]
    for number in numbers(name, count):
        rng = random_of(name, number)
        file = rng.choice(small)
        data = file.read_bytes()
        try:
            yield number, file, mutate_tree(data, rng) if rng.random() < 0.4 else mutate(data, rng)
        except ScenarioError:  # a sample that is no XML has no tree
            yield number, file, mutate(data, rng)


def test_mutated_files_raise_nothing_but_findings(
    samples: tuple[list[Path], list[Path]], monkeypatch: pytest.MonkeyPatch
) -> None:
    files, library = samples
    for number, file, data in mutants(files, "scenarios", COUNT):
        # the mutated bytes in place of the file's, so that its road and catalogues are found
        monkeypatch.setattr("openscenario.read.scenario.read_xml", instead_of(file, data))
        try:
            findings = check_scenario(file, library=library)
        except Exception as error:
            raise AssertionError(f"mutation {number} of {file}") from error
        assert all(isinstance(finding, Finding) for finding in findings)


def test_what_is_read_from_a_mutated_file_is_written_and_reads_back(
    samples: tuple[list[Path], list[Path]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files, library = samples
    survivors = 0
    tried = 0
    for _, file, data in mutants(files, "written scenarios", COUNT // 10):
        tried += 1
        with monkeypatch.context() as patched:
            patched.setattr("openscenario.read.scenario.read_xml", instead_of(file, data))
            try:
                scenario = read_scenario(file, library=library)
            except ScenarioError:
                continue
        survivors += 1
        write_scenario(scenario, tmp_path / "copy.xosc")
        assert read_scenario(tmp_path / "copy.xosc", library=library) == scenario
    assert survivors > 0 or tried == 0


def instead_of(file: Path, data: bytes) -> Callable[[Path], Document]:
    """A reader that finds `data` in `file`, and other files as they are."""
    return lambda path: parse_xml(data, str(path)) if Path(path) == file else read_xml(path)
