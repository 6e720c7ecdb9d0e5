"""Parts of one's own in the reference stack, as docs/your-ads.md prints them."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import pytest
from ads_loop import TABBY, Car, drive
from ads_plane import PlaneMap

from ads.parameters import Parameters
from ads.perception.pipeline import TrackingPerception
from ads.stack import Stack
from vehicle.messages import RoadPoint, Task

PAGE = (Path(__file__).parents[3] / "docs" / "your-ads.md").read_text(encoding="utf-8")
SWAPPED, NEURAL = re.findall(r"```python\n(.*?)```", PAGE.split("## Swap one part")[1], re.DOTALL)


def names_of(code: str) -> dict[str, object]:
    found: dict[str, object] = {}
    exec(code, found)  # noqa: S102, what the page prints is what is run
    return found


def test_the_localization_of_the_page_drives_to_the_goal():
    stack = names_of(SWAPPED)["make"](Parameters(), PlaneMap([(200.0, 0.0)]), TABBY)
    assert type(stack.localizer).__name__ == "LastFix"
    log = drive(stack, Car(TABBY, 5.0, -1.75, 0.0, 5.0), 30.0, Task(goal=RoadPoint("1", -1, 100.0)))
    assert log.column(1)[-1] == pytest.approx(100.0, abs=1.0)
    assert max(log.off_path) < 0.5


def test_the_neural_detector_of_the_page_becomes_the_detector(tmp_path, monkeypatch):
    pytest.importorskip("onnxruntime", reason="extra `onnx` is not installed")
    pytest.importorskip("onnx", reason="package onnx, which makes the model, is not installed")
    from test_ads_onnx import made

    made(tmp_path).rename(tmp_path / "my_detector.onnx")
    monkeypatch.chdir(tmp_path)
    stack = names_of(NEURAL)["make"](Parameters(), PlaneMap([(200.0, 0.0)]), TABBY)
    assert type(stack.perception._detector).__name__ == "OnnxDetector"


@pytest.mark.parametrize("row", re.findall(r"^\| \S.*\| `ads\..*\|$", PAGE, re.MULTILINE))
def test_every_interface_of_the_table_is_one_with_these_methods(row):
    _, argument, has, interface = (cell.strip().strip("`") for cell in row.strip("|").split("|"))
    module, _, name = interface.rpartition(".")
    protocol = getattr(__import__(module, fromlist=[name]), name)
    assert getattr(protocol, "_is_protocol", False)
    method, given = re.match(r"(\w+)\((.*?)\)", has).groups()
    taken = list(inspect.signature(getattr(protocol, method)).parameters)[1:]
    if given != "...":
        assert len(taken) == len(given.split(","))
    owner = TrackingPerception if "TrackingPerception" in argument else Stack
    keyword = re.search(r"(\w+)=?\)?$", argument.strip("`")).group(1)
    assert keyword in inspect.signature(owner).parameters
