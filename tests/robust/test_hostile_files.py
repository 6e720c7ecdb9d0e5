"""Each value of the shipped files spoilt in turn, and files that attack their reader: found at their place.

What must be refused follows from the file alone: a number that is none, a name that nothing has, a word with a slip.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from openscenario.findings import Finding
from openscenario.read import check_scenario
from openscenario.road.opendrive import examine_opendrive

NO_NUMBERS = ("NaN", "-INF", "-1e309", "12 m", "1_0", "0x10")
FREE = {"revMajor", "revMinor", "name", "description", "author", "date", "filepath", "id", "subtype", "version"}
FREE |= {"elementId", "incomingRoad", "connectingRoad", "junction", "roadId", "state", "outlineId"}
TEXTS = ("Property", "signal")  # whose values are what their tool takes them for
WORDS = {
    *("rule", "dynamicsShape", "dynamicsDimension", "priority", "conditionEdge", "parameterType", "vehicleCategory"),
    *("pedestrianCategory", "miscObjectCategory", "storyboardElementType", "state", "contactPoint", "elementType"),
}
NAMES = {"entityRef", "storyboardElementRef", "roadId", "entryName", "catalogName", "elementId", "incomingRoad"}
TAG = re.compile(r"<([A-Za-z]\w*)((?:\s+[\w:]+=\"[^\"]*\")+)\s*/?>")
ATTRIBUTE = re.compile(r"([\w:]+)=\"([^\"]*)\"")
ENTITY = '<!DOCTYPE x [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;"><!ENTITY f SYSTEM "file:///etc/passwd">]>'


class Place(NamedTuple):
    """An attribute of a file: where its value stands in the text, its line and element."""

    start: int
    end: int
    line: int
    tag: str
    attribute: str
    value: str


def places(text: str) -> Iterator[Place]:
    for tag in TAG.finditer(text):
        line = text.count("\n", 0, tag.start()) + 1
        for found in ATTRIBUTE.finditer(tag[2]):
            start = tag.start(2) + found.start(2)
            yield Place(start, start + len(found[2]), line, tag[1], found[1], found[2])


def is_number(text: str) -> bool:
    return re.fullmatch(r"[-+]?\d+(\.\d*)?(e[-+]?\d+)?", text) is not None


@pytest.fixture
def folder(tmp_path: Path, scenarios_dir: Path) -> Path:
    """A copy of the shipped scenarios, to spoil."""
    shutil.copytree(scenarios_dir, tmp_path / "files", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path / "files"


def errors(path: Path) -> list[Finding]:
    found = examine_opendrive(path)[1] if path.suffix == ".xodr" else check_scenario(path)
    return [finding for finding in found if finding.severity == "error"]


def last(element: str) -> tuple[str, str]:
    tag, _, attribute = re.sub(r"\[[^\]]*\]", "", element).split("/")[-1].partition("@")
    return tag, attribute


def spoilt(path: Path, place: Place, value: str) -> list[Finding]:
    """The errors of the file with another value at the place."""
    text = path.read_text(encoding="utf-8")
    other = path.with_name(f"spoilt{path.suffix}")
    other.write_text(text[: place.start] + value + text[place.end :], encoding="utf-8")
    return errors(other)


def misplaced(found: list[Finding], place: Place) -> str:
    """Empty if one of the findings is at the place."""
    if any(finding.line == place.line and last(finding.element) == (place.tag, place.attribute) for finding in found):
        return ""
    return f"line {place.line} {place.tag}@{place.attribute}: {[str(finding) for finding in found[:2]]}"


@pytest.mark.parametrize("name", ["pedestrian_crossing.xosc", "overtaking.xosc", "urban.xodr"])
def test_a_number_that_is_none_is_found_at_its_attribute(folder: Path, name: str) -> None:
    path = folder / name
    text = path.read_text(encoding="utf-8")
    numbers = [p for p in places(text) if is_number(p.value) and p.attribute not in FREE and p.tag not in TEXTS]
    step = max(1, len(numbers) // 150)  # of a large file each kind of element stands many times
    wrong = []
    for index, place in enumerate(numbers[::step]):
        value = NO_NUMBERS[index % len(NO_NUMBERS)]
        wrong.append(misplaced(spoilt(path, place, value), place))
    assert len(wrong) > 30
    assert [each for each in wrong if each] == []


@pytest.mark.parametrize("name", ["pedestrian_crossing.xosc", "overtaking.xosc", "urban.xodr"])
def test_a_word_or_name_with_a_slip_is_found_with_the_right_one(folder: Path, name: str) -> None:
    path = folder / name
    asked = 0
    for place in places(path.read_text(encoding="utf-8")):
        if place.attribute not in WORDS | NAMES or len(place.value) < 5 or place.value.startswith("$"):
            continue
        asked += 1
        slip = place.value[:2] + place.value[3:]
        found = spoilt(path, place, slip)
        assert misplaced(found, place) == ""
        here = next(finding for finding in found if finding.line == place.line)
        assert place.value in str(here)  # offered as the nearest, or among the allowed
    assert asked > 0


def test_a_missing_attribute_is_found_at_its_element(folder: Path) -> None:
    path = folder / "pedestrian_crossing.xosc"
    text = path.read_text(encoding="utf-8")
    optional = {"offset", "maximumExecutionCount", "delay", "conditionEdge", "rule", "revMajor", "revMinor", "h"}
    optional |= {"coordinateSystem", "routingAlgorithm", "freespace", "relativeDistanceType", "model3d", "mass", "role"}
    asked = 0
    for place in places(text):
        if place.attribute in optional or place.attribute == "name":
            continue
        begin = text.rindex(place.attribute, 0, place.start)
        path.with_name("spoilt.xosc").write_text(text[:begin] + text[place.end + 1 :], encoding="utf-8")
        found = errors(path.with_name("spoilt.xosc"))
        asked += bool(found)
        assert not found or any(finding.line == place.line for finding in found), place
    assert asked > 40


ATTACKS = {
    "entities": lambda text: text.replace("<OpenSCENARIO", ENTITY + "<OpenSCENARIO", 1),
    "entities in UTF-16": lambda text: (
        text.replace("UTF-8", "UTF-16").replace("<OpenSCENARIO", ENTITY + "<OpenSCENARIO", 1).encode("utf-16")
    ),
    "undefined entity": lambda text: text.replace('description="', 'description="&lol;', 1),
    "cut": lambda text: text[: len(text) // 2],
    "not a tag": lambda text: text + "<",
    "two roots": lambda text: text + "<OpenSCENARIO/>",
    "NUL": lambda text: text.replace('description="', 'description="\0', 1),
    "surrogate": lambda text: text.encode().replace(b'description="', b'description="\xed\xa0\x80', 1),
    "wrong encoding": lambda text: text.encode().replace(b'description="', b'description="\xff', 1),
    "unknown encoding": lambda text: text.replace("UTF-8", "UTF-7"),
    "declared UTF-32, is not": lambda text: text.replace("UTF-8", "UTF-32"),
    "empty": lambda text: "",
    "blank": lambda text: " " * 1_000_000,
    "binary": lambda text: bytes(range(256)) * 1000,
    "open tags": lambda text: "<" * 1_000_000,
    "open comments": lambda text: text.replace("<OpenSCENARIO", "<!--" * 50_000 + "<OpenSCENARIO", 1),
    "deep": lambda text: "<OpenSCENARIO>" + "<a>" * 100_000,
    "wide": lambda text: text.replace("<Entities>", "<Entities>" + "<Foo/>" * 20_000),
    "attributes": lambda text: text.replace("<Entities", "<Entities " + " ".join(f'a{n}=""' for n in range(20_000))),
    "attribute twice": lambda text: text.replace('revMajor="1"', 'revMajor="1" revMajor="1"'),
    "long attribute": lambda text: text.replace('description="', 'description="' + "x" * 200_000, 1),
    "parameters in a circle": lambda text: text.replace(
        "<ParameterDeclarations>",
        '<ParameterDeclarations><ParameterDeclaration name="a" parameterType="double" value="$b"/>'
        '<ParameterDeclaration name="b" parameterType="double" value="$a"/>',
    ),
    "power": lambda text: text.replace(
        "<ParameterDeclarations>",
        '<ParameterDeclarations><ParameterDeclaration name="a" parameterType="double" value="${pow(9,pow(9,9))}"/>',
    ),
    "parentheses": lambda text: text.replace(
        "<ParameterDeclarations>",
        '<ParameterDeclarations><ParameterDeclaration name="a" parameterType="double" value="${'
        + "(" * 3_000
        + '1}"/>',
    ),
    "include": lambda text: text.replace(
        "<Entities>", '<Entities><xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="/etc/passwd"/>'
    ),
    "DSL": lambda text: "import osc.standard\nscenario top:\n    do serial:\n",
    "CommonRoad": lambda text: '<commonRoad commonRoadVersion="2020a"/>',
    "Lanelet2": lambda text: '<osm version="0.6"/>',
}


@pytest.mark.parametrize("attack", ATTACKS)
def test_an_attack_is_refused_in_one_short_line_each(folder: Path, attack: str) -> None:
    path = folder / "overtaking.xosc"
    made = ATTACKS[attack](path.read_text(encoding="utf-8"))
    path.write_bytes(made if isinstance(made, bytes) else made.encode())
    found = errors(path)
    assert found
    for finding in found:
        assert finding.line is not None
        assert "\n" not in str(finding)
        assert len(str(finding)) < 1_000
        assert "root:" not in str(finding)


@pytest.mark.parametrize(("attack", "advice"), [("DSL", "DSL"), ("CommonRoad", "CommonRoad"), ("Lanelet2", "lanelet2")])
def test_another_format_is_refused_by_name(folder: Path, attack: str, advice: str) -> None:
    path = folder / "overtaking.xosc"
    path.write_text(str(ATTACKS[attack]("")))
    assert advice in str(errors(path)[0])


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-32"])
def test_every_encoding_of_unicode_is_read(folder: Path, encoding: str) -> None:
    path = folder / "overtaking.xosc"
    path.write_bytes(path.read_text(encoding="utf-8").encode(encoding))
    assert errors(path) == []


def road_of(folder: Path, written: str) -> list[Finding]:
    """The errors of a scenario whose road is written so."""
    path = folder / "overtaking.xosc"
    text = re.sub(r'(<LogicFile filepath=")[^"]*', lambda match: match[1] + written, path.read_text(encoding="utf-8"))
    path.write_text(text, encoding="utf-8")
    line = text.count("\n", 0, text.index("<LogicFile")) + 1
    return [
        finding
        for finding in errors(path)
        if (finding.line, last(finding.element)) == (line, ("LogicFile", "filepath"))
    ]


PATHS = (
    *("/etc/passwd", "../../../../etc/passwd", "..%2f..%2fetc/passwd", "..%252f..%252fetc%252fpasswd", "..\\..\\etc"),
    *(
        "http://127.0.0.1:9/x.xodr",
        "file:///etc/passwd",
        "C:\\road.xodr",
        "\\\\host\\share\\r.xodr",
        "no_such.xodr",
    ),
    *(".", "x" * 5_000, "urban.xodr/..", "~/road.xodr"),
)


@pytest.mark.parametrize("written", PATHS, ids=lambda text: text[:24] or "empty")
def test_a_path_that_is_no_road_of_ours_is_refused(folder: Path, written: str) -> None:
    assert len(road_of(folder, written)) == 1


def test_links_and_things_that_are_no_files_are_refused(folder: Path) -> None:
    (folder / "loop.xodr").symlink_to("loop.xodr")
    (folder / "out.xodr").symlink_to("/etc/passwd")
    (folder / "folder.xodr").mkdir()
    os.mkfifo(folder / "pipe.xodr")  # opening it would wait for ever
    for name in ("loop.xodr", "out.xodr", "folder.xodr", "pipe.xodr"):
        assert len(road_of(folder, name)) == 1, name


WATCH = """
import encodings.utf_16, encodings.utf_32, json, sys
from pathlib import Path
from openscenario.read import check_scenario
check_scenario(sys.argv[1])
opened = []
def watch(event, arguments):
    if event in {"open", "os.listdir", "os.scandir", "socket.connect", "socket.getaddrinfo", "subprocess.Popen"}:
        opened.append([event, str(arguments[0])])
sys.addaudithook(watch)
for name in sys.argv[2:]:
    check_scenario(name)
print(json.dumps(opened))
"""


def test_nothing_outside_the_folder_is_opened(folder: Path) -> None:
    """A fresh interpreter reads all attacks and all paths; what it opens is told by Python's audit hook."""
    text = (folder / "overtaking.xosc").read_text(encoding="utf-8")
    names = []
    for number, attack in enumerate(ATTACKS.values()):
        made = attack(text)
        names.append(folder / f"attack{number}.xosc")
        names[-1].write_bytes(made if isinstance(made, bytes) else made.encode())
    for number, written in enumerate(PATHS):
        names.append(folder / f"path{number}.xosc")
        names[-1].write_text(re.sub(r'(<LogicFile filepath=")[^"]*', lambda m, to=written: m[1] + to, text))
    command = [sys.executable, "-c", WATCH, str(folder / "urban.xosc"), *map(str, names)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    for event, what in json.loads(done.stdout):
        assert event in ("open", "os.scandir", "os.listdir"), (event, what)
        assert Path(what).resolve().is_relative_to(folder.resolve()), (event, what)
