"""`dvp effects` and the page made of the catalogue."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main
from vehicle.model.effect_catalogue import catalogue

MINE = """
from vehicle.model.effect import Key, effect

@effect(
    name="magnet", slot="force",
    physics="a magnet at the end of the road pulls the car", equation="a = c", source="my notebook",
    parameters=(Key("c", "m/s^2", low=0.1, high=1.0, neutral=0.0, least=0.05, meaning="pull"),),
    reveals="stand still with released brake",
)
def magnet(x, p, m):
    x.drag += p.c * x.mass
"""


def test_the_page_shows_the_catalogue_as_it_is() -> None:
    from scripts.make_effects_page import PAGE, page

    assert PAGE.read_text(encoding="utf-8") == page(), "python -m scripts.make_effects_page"


def test_the_pages_example_is_the_effect_of_this_test() -> None:
    from scripts.make_effects_page import PAGE

    assert MINE.strip() in PAGE.read_text(encoding="utf-8")


def test_the_list_has_a_line_for_each_effect(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(catalogue())


def test_one_effect_is_shown_with_equation_keys_and_source(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "understeer"]) == 0
    shown = capsys.readouterr().out
    assert "r = v d/(L + K v^2)" in shown
    assert "rad s^2/m" in shown
    assert "Rajamani" in shown


def test_json_is_one_document_without_infinities(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "--json"]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=lambda text: pytest.fail(text))
    assert [e["name"] for e in found["effects"]] == list(catalogue())
    brake = next(e for e in found["effects"] if e["name"] == "brake_limit")
    assert brake["parameters"]["limit"]["neutral"] is None


def test_a_wrong_name_is_answered_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "understear"]) == 2
    assert "did you mean 'understeer'" in capsys.readouterr().err


def test_a_users_effect_stands_beside_the_built_in_ones(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "my_effect.py"
    file.write_text(MINE, encoding="utf-8")
    assert main(["effects", "magnet", "--effects", str(file)]) == 0
    assert "a = c" in capsys.readouterr().out


def test_a_users_effect_cannot_take_a_known_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "my_effect.py"
    file.write_text(MINE.replace('"magnet"', '"steer_lag"'), encoding="utf-8")
    assert main(["effects", "--effects", str(file)]) == 1
    assert "steer_lag: there is an effect of this name already" in capsys.readouterr().err


def test_a_missing_file_of_effects_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "--effects", "nowhere.py"]) == 2
    assert capsys.readouterr().err.startswith("nowhere.py: no such file of effects; looked in ")


def test_a_users_effect_replays_a_log_like_a_built_in_one(tmp_path: Path) -> None:
    import numpy as np

    from vehicle.model.effect_catalogue import effects_of_file
    from vehicle.model.model_file import parse_model
    from vehicle.model.open_loop import Replay

    file = tmp_path / "my_effect.py"
    file.write_text(MINE, encoding="utf-8")
    nought = {"steer_cmd": np.zeros(101), "accel_cmd": np.zeros(101)}
    found = parse_model("[parameters]\nwheelbase = 2.0\n")
    replay = Replay(found, np.arange(101) * 0.02, nought, extra=effects_of_file(file).values())
    rows = replay.run({("magnet", "c"): 0.5, ("drive_lag", "tau"): 0.2})
    assert rows[-1, 3] == pytest.approx(0.5 * 2.0)  # m/s after 2 s


def test_every_field_of_the_bus_is_listed_with_unit_and_meaning(capsys: pytest.CaptureFixture[str]) -> None:
    from scripts.make_effects_page import PAGE
    from vehicle.model.bus import BUS_FIELDS

    assert main(["effects", "--fields", "--json"]) == 0
    fields = json.loads(capsys.readouterr().out)["fields"]
    assert [f["name"] for f in fields] == list(BUS_FIELDS)
    assert all(f["unit"] and f["meaning"] and f["group"] for f in fields)
    assert all(f"`x.{name}`" in PAGE.read_text(encoding="utf-8") for name in BUS_FIELDS)
    assert main(["effects", "--help"]) == 0
    assert "tangent_front" in capsys.readouterr().out


def test_a_value_outside_the_usual_range_is_taken_one_outside_the_allowed_is_not() -> None:
    from vehicle.model.effect import Key
    from vehicle.model.errors import ModelError

    key = Key("T", "s", low=0.1, high=0.5, neutral=0.0, least=0.01, minimum=0.0, maximum=1.0)
    assert key.check(0.9) == 0.9
    assert key.allowed == "0 to 1"
    with pytest.raises(ModelError, match="0 to 1 s"):
        key.check(1.1)
