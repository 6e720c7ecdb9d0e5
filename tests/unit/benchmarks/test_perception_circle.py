"""A perception effect hidden in the car is found in its log, added to the twin, and shows in the twin's next drive."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("cyclonedds")

import scenarios
from benchmarks.perception_circle.circle import Circle, Shown, circle
from benchmarks.perception_circle.scene import write_street
from benchmarks.perception_circle.table import BEGIN, END, alike, table, written_into
from vehicle.model.model_file import read_model


@pytest.mark.nightly
def test_the_twin_sees_what_the_car_sees_once_it_has_the_hidden_effect(tmp_path: Path) -> None:
    """Another program hides the offset, with a LiDAR and a camera of its own; the stack is the same on both."""
    scenario = write_street(tmp_path / "street", 8.0)
    model = read_model(scenarios.path("models/surrogate.toml"))
    hidden = {"detection_offset": {"x": 1.2, "y": -0.6}}
    one = circle(scenario, tmp_path, model, hidden, rounds=1)
    assert "detection_offset" in one.named
    assert one.found["detection_offset"]["x"] == pytest.approx(1.2, abs=0.12)
    assert one.found["detection_offset"]["y"] == pytest.approx(-0.6, abs=0.06)
    assert one.car.position_error is not None
    assert one.before.position_error is not None
    assert one.after.position_error is not None
    assert one.before.position_error < 0.5 * one.car.position_error
    assert one.after.position_error == pytest.approx(one.car.position_error, rel=0.1)
    assert one.after.recall == pytest.approx(one.car.recall, rel=0.1)


def answer(recall: float, position: float, latency: float | None) -> Circle:
    return Circle(
        {"detection_latency": {"T": 0.2}},
        ("detection_latency",),
        {"detection_misses": {"rate": 0.3, "slope": 0.0}},
        Shown(0.8, 0.5, 0.2, None, None),
        Shown(1.0, 0.1, 0.0, None, None),
        Shown(recall, position, latency, None, None),
    )


def test_alike_is_within_a_tenth_of_the_cars_value() -> None:
    assert alike(answer(0.87, 0.54, 0.21)) == (True, True, True)
    assert alike(answer(0.89, 0.56, 0.23)) == (False, False, False)
    assert alike(answer(0.8, 0.5, None)) == (True, True, False)


def test_the_table_names_what_misses_and_replaces_itself_on_its_page() -> None:
    row = table([answer(0.8, 0.6, 0.2)]).splitlines()[-1]
    assert row.startswith("| `detection_latency` T 0.2 | `detection_misses` rate 0.3 | 0.800, 1.000, 0.800 |")
    assert row.endswith("| not position error |")
    page = f"before\n{BEGIN}\nold\n{END}\nafter\n"
    assert written_into(page, "new") == f"before\n{BEGIN}\nnew\n{END}\nafter\n"
    with pytest.raises(ValueError, match="circle"):
        written_into("no marks", "new")
