"""Writing: what was read and written reads back equal, and the file is valid."""

from __future__ import annotations

from pathlib import Path

import pytest
from xosc_samples import Spoil

from openscenario.read import read_scenario
from openscenario.write import write_scenario


def test_a_written_scenario_reads_back_equal(spoil: Spoil, tmp_path: Path) -> None:
    scenario = read_scenario(spoil())
    write_scenario(scenario, tmp_path / "copy.xosc")
    assert read_scenario(tmp_path / "copy.xosc") == scenario


def test_a_variant_keeps_its_values(spoil: Spoil, tmp_path: Path) -> None:
    variant = read_scenario(spoil(), parameters={"EgoSpeed": 13.3})
    write_scenario(variant, tmp_path / "variant.xosc")
    assert read_scenario(tmp_path / "variant.xosc") == variant
    assert 'value="13.3"' in (tmp_path / "variant.xosc").read_text()


def test_the_road_is_found_from_another_folder(spoil: Spoil, tmp_path: Path) -> None:
    scenario = read_scenario(spoil())
    (tmp_path / "variants").mkdir()
    write_scenario(scenario, tmp_path / "variants" / "x.xosc")
    assert read_scenario(tmp_path / "variants" / "x.xosc", library=[tmp_path]) == scenario


def test_names_with_markup_survive(spoil: Spoil, tmp_path: Path) -> None:
    scenario = read_scenario(spoil('name="event"', 'name="&lt;b&gt; &amp; &quot;Ж&quot;&#10;\'"'))
    write_scenario(scenario, tmp_path / "copy.xosc")
    copy = read_scenario(tmp_path / "copy.xosc")
    assert copy == scenario
    assert copy.storyboard.stories[0].acts[0].maneuver_groups[0].maneuvers[0].events[0].name == '<b> & "Ж"\n\''


def test_nothing_is_left_when_writing_fails(spoil: Spoil, tmp_path: Path) -> None:
    scenario = read_scenario(spoil())
    (tmp_path / "taken").mkdir()
    before = sorted(entry.name for entry in tmp_path.iterdir())
    with pytest.raises(IsADirectoryError):
        write_scenario(scenario, tmp_path / "taken")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == before
