"""Parameters that a driving stack of one's own declares: set by P.NAME=VALUE, refused by its own names."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from ads.parameters import ParameterError, Parameters, preset
from pytest_dvp.cli.command_line import main
from pytest_dvp.drive.remote_stack import RemoteStack
from pytest_dvp.drive.run import run
from pytest_dvp.drive.stack_faults import AdsError
from pytest_dvp.drive.stack_host import find_ads, make_driver
from pytest_dvp.drive.stack_parameters import check_parameters, in_force, known_of
from pytest_dvp.drive.stack_server import received
from pytest_dvp.text.errors import SettingError
from vehicle.messages import Command, Observation

Write = Callable[..., Path]
SPEEDS = """
from vehicle.messages import Command


class Keeper:
    parameters = {"LK_accel": 0.0, "LK_ticks": 10}

    def __init__(self, parameters, network, description):
        self.trace = {"accel": parameters.get("LK_accel"), "whole": float(isinstance(parameters["LK_ticks"], int))}

    def tick(self, observation):
        return Command(observation.t, 0.0, 0.0, self.trace["accel"] / 3.5, 0.0)
"""


class Keeper:
    parameters: Mapping[str, float] = {"LK_look": 1.2, "LK_ticks": 10}

    def __init__(self, parameters: Mapping[str, float], network: object, description: object) -> None:
        self.given = parameters

    def tick(self, observation: Observation) -> Command:
        return Command(observation.t, 0.0, 0.0, 0.0, 0.0)


class Silent(Keeper):
    """Declares none."""

    parameters: Mapping[str, float] = {}


def test_set_reaches_the_stack_the_log_and_the_replay(scenario: Write, tmp_path: Path, monkeypatch, capsys) -> None:
    scenario()
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(SPEEDS)
    options = ["--ads", "mine.py:Keeper", "--duration", "2", "--json"]
    speeds = []
    for value in ("0", "1.0"):
        main(["run", "x.xosc", *options, "--set", f"P.LK_accel={value}"])
        result = json.loads(capsys.readouterr().out)
        assert f"--set P.LK_accel={value}" in result["replay"]
        log = run("x.xosc", ads="mine.py:Keeper", P={"LK_accel": value}, duration=2.0).log
        assert log.meta["P"] == {"LK_accel": float(value), "LK_ticks": 10}
        assert (log["ads.accel"][-1], log["ads.whole"][-1]) == (float(value), 1.0)
        speeds.append(log["v"][-1])
    assert speeds[1] > speeds[0] + 0.5


def test_an_unknown_name_is_one_line_with_the_stacks_own_nearest(
    scenario: Write, tmp_path: Path, monkeypatch, capsys
) -> None:
    scenario()
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(SPEEDS)
    assert main(["run", "x.xosc", "--ads", "mine.py:Keeper", "--set", "P.LK_acel=1"]) == 2
    assert capsys.readouterr().err.splitlines() == [
        "--set: ADS mine.py:Keeper: unknown parameter 'LK_acel', did you mean 'LK_accel'?"
    ]


def test_what_is_not_set_keeps_its_default_and_each_run_has_its_own_dict() -> None:
    ads = find_ads(Keeper)
    first, second = in_force(ads, {"LK_look": "1.0"}, "dt"), in_force(ads, {}, "dt")
    assert (first, second) == ({"LK_look": 1.0, "LK_ticks": 10}, {"LK_look": 1.2, "LK_ticks": 10})
    assert make_driver(ads, first, None, None)._driver.given is first
    assert second is not Keeper.parameters


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("LK_look", "fast", "parameter LK_look: found 'fast', expected a finite number"),
        ("LK_look", "inf", "parameter LK_look: found 'inf', expected a finite number"),
        ("LK_ticks", "2.5", r"found 2.5, expected a whole number, as its default 10 is \(10.0 allows any\)"),
        ("LQR_q11", "30", "unknown parameter 'LQR_q11', allowed: LK_look, LK_ticks"),
    ],
)
def test_a_value_that_the_stack_cannot_take_is_one_line(name: str, value: str, says: str) -> None:
    with pytest.raises(SettingError, match=f"^--set: ADS test_own_parameters.py:Keeper: .*{says}"):
        check_parameters(find_ads(Keeper), {name: value})


def test_a_whole_default_stays_whole() -> None:
    ticks = in_force(find_ads(Keeper), {"LK_ticks": 20.0}, "dt")["LK_ticks"]
    assert (ticks, type(ticks)) == (20, int)


def test_a_stack_that_declares_none_gets_those_of_the_reference_stack() -> None:
    ads = find_ads(Silent)
    assert in_force(ads, {"LQR_q11": "20"}, "rw") == preset(10, "rw").with_values({"LQR_q11": 20.0})
    with pytest.raises(ParameterError):
        in_force(ads, {"LK_look": 1.0}, "dt")
    with pytest.raises(SettingError, match="Silent declares no `parameters` of its own, so P is that of"):
        check_parameters(ads, {"LK_look": 1.0})


@pytest.mark.parametrize("default", ["1.2", True, float("nan"), None])
def test_a_default_that_is_no_number_is_one_line(default: object) -> None:
    class Wrong(Keeper):
        parameters: Mapping[str, object] = {"LK_look": default}

    with pytest.raises(AdsError, match=r"the default of LK_look is .*, expected a finite number"):
        in_force(find_ads(Wrong), {}, "dt")


def test_parameters_that_nobody_takes_are_one_line() -> None:
    class Deaf:
        parameters: Mapping[str, float] = {"LK_look": 1.2}

        def tick(self, observation: Observation) -> Command: ...

    with pytest.raises(AdsError, match=r"declares parameters, and takes no \(parameters, network, description\)"):
        make_driver(find_ads(Deaf), {"LK_look": 1.2}, None, None)


def test_of_a_sessions_values_a_stack_gets_those_it_has() -> None:
    values = {"LK_look": "1.0", "LQR_q11": "20"}
    assert known_of(find_ads(Keeper), values) == {"LK_look": "1.0"}
    assert known_of(find_ads(), values) == {"LQR_q11": "20"}


def test_a_stack_in_a_process_of_its_own_declares_them_in_its_file(tmp_path: Path) -> None:
    file = tmp_path / "stack.toml"
    file.write_text('command = ["x"]\n[parameters]\nLK_look = 1.2\n')
    assert in_force(find_ads(RemoteStack(file)), {"LK_look": "1.0"}, "dt") == {"LK_look": 1.0}


def test_over_the_wire_a_stack_takes_its_own_and_no_others() -> None:
    ads = find_ads(Keeper)
    assert received(ads, {"LK_look": 1.0}) == {"LK_look": 1.0, "LK_ticks": 10}
    assert received(ads, Parameters().as_dict()) == {"LK_look": 1.2, "LK_ticks": 10}
    with pytest.raises(AdsError, match="unknown parameter 'LK_lok', did you mean 'LK_look'"):
        received(ads, {"LK_lok": 1.0})
    assert received(find_ads(Silent), {"LQR_q11": 20.0}) == Parameters().with_values({"LQR_q11": 20.0})
