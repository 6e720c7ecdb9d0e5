"""The page of a run tells what limited tyres and sensors, and since when; nothing where the scenario says nothing."""

from __future__ import annotations

import pytest

from reports.panels import weather
from reports.panels.panel import Run
from reports.templating import environment


def shown(*events: tuple[float, str, str, str]) -> str | None:
    rows = [dict(zip(("t", "kind", "element", "text"), event, strict=True)) for event in events]
    values = weather.values(Run({}, {}, (), rows, {}, (), (), {}))
    return None if values is None else environment().from_string(weather.TEMPLATE).render(**values)


@pytest.mark.parametrize("text", ["friction coefficient 0.3", "extinction 0.0599 1/m", "wind 9 m/s towards 0 rad"])
def test_it_shows_each_change_with_its_moment(text: str) -> None:
    page = shown((0.0, "environment", "wet", text), (2.5, "environment", "road", "dry road, clear air"))
    assert page is not None
    assert text in page
    assert 'data-t="2.5"' in page
    assert page.index(text) < page.index("dry road")


def test_there_is_no_panel_without_weather() -> None:
    assert shown((1.0, "goal", "Ego", "")) is None


def test_names_of_a_file_are_escaped() -> None:
    assert "<script>" not in str(shown((0.0, "environment", "<script>", "x")))
