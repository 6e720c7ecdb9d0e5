"""A car that says it is real: two keys, a dry run without them, and nothing automatic ever drives it."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import scenarios
from pytest_dvp.cli.command_line import main
from pytest_dvp.drive.announced_cars import is_real, label, may_repeat, refuse_repetition
from pytest_dvp.drive.run import run
from pytest_dvp.drive.stages import StageError
from pytest_dvp.logs.log import Log
from tests.unit.harness.conftest import OneTrick, coast
from tests.unit.harness.test_loop import WITH_TARGET
from vehicle.guard.envelope import EnvelopeError
from vehicle.guard.guard import ArmingRefused
from vehicle.messages import Command, Observation

Write = Callable[..., Path]

CAR = """
from msgspec import structs
from scenarios import path
from vehicle.adapter import Hands, VehicleLost
from vehicle.model.model_file import read_model
from vehicle.sensors import default_sensors
from vehicle.twin import Twin
from vehicle.wire.health import Trouble

TOLD = []


class Car(Twin):
    # A car behind the protocol; that it is a twin inside, nobody is told.
    is_real = True
    hands = Hands(False, False)

    def __init__(self, argument):
        super().__init__(read_model(path("models/tabby_evo.toml")), default_sensors())

    def apply(self, command):
        TOLD.append(command)
        super().apply(command)


class Standing(Car):
    # Nobody can make a car roll by a word.
    def reset(self, state):
        super().reset(structs.replace(state, v=0.0, vx=0.0))


class Toy(Car):
    is_real = False


class Lost(Toy):
    # Gone after half a second, and then not to be asked to stop either.
    def step(self, dt):
        self.stop()
        return super().step(dt)

    def stop(self):
        if len(TOLD) > 25:
            raise VehicleLost("the car has been silent for 0.16 s")


class Noisy(Toy):
    # One message is missing, in the step from t = AT on.
    AT = 0.5

    def tell(self, record):
        self.record, self.t = record, 0.0

    def step(self, dt):
        if self.t - 1e-9 <= self.AT < self.t + dt - 1e-9:
            self.record(Trouble(self.t, "/gnss/fix", "lost", 1.0))
        self.t += dt
        return super().step(dt)


def lying(argument):
    return Car(argument)


lying.is_real = False


def unknown(argument):
    return Car(argument)


def none(argument):
    return "a car"
"""


@pytest.fixture
def told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Command]:
    """A package that announces cars of its own; what the real one was told."""
    site = tmp_path / "site"
    info = site / "mycar-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: mycar\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[pytest_dvp.adapters]\ntabby = mycar_for_tests:Car\ntoy = mycar_for_tests:Toy\n"
        "lying = mycar_for_tests:lying\nunknown = mycar_for_tests:unknown\nnone = mycar_for_tests:none\n"
        "broken = mycar_for_tests:nothing\nlost = mycar_for_tests:Lost\nstanding = mycar_for_tests:Standing\n"
        "noisy = mycar_for_tests:Noisy\n"
    )
    (site / "mycar_for_tests.py").write_text(CAR)
    monkeypatch.syspath_prepend(site)
    import mycar_for_tests  # type: ignore[import-not-found]

    mycar_for_tests.TOLD.clear()
    commands: list[Command] = mycar_for_tests.TOLD
    return commands


@pytest.fixture
def keys(scenario: Write) -> dict[str, Path]:
    """A scenario, an arming for it, and an envelope around it."""
    path = scenario()
    arming, envelope = path.with_name("arming.toml"), path.with_name("envelope.toml")
    arming.write_text(f'vehicle = "tabby"\nscenario = "{path.name}"\n')
    envelope.write_text("area = [[-50, -50], [1050, -50], [1050, 50], [-50, 50]]\nmax_speed = 8.0\n")
    return {"scenario": path, "arming": arming, "envelope": envelope}


class Coasting:
    """A stack that asks for nothing but a little acceleration."""

    def tick(self, observation: Observation) -> Command:
        return Command(observation.t, 0.0, 0.3, 0.1, 0.0)


def drive(keys: dict[str, Path], *, vehicle: str = "tabby", with_keys: bool = True, **options: object):  # type: ignore[no-untyped-def]
    given = {"arming": keys["arming"], "envelope": keys["envelope"]} if with_keys else {}
    return run(keys["scenario"], **{"stage": "pe", **options}, vehicle=vehicle, ads=Coasting, duration=1.0, **given)  # type: ignore[arg-type]


NO_GATES = '[[gate]]\nmetric = "collision"\nmax = 0\n'


@pytest.fixture(autouse=True)
def gates(keys: dict[str, Path]) -> None:
    path = keys["scenario"]
    path.with_name(f"{path.stem}.gates.toml").write_text(NO_GATES)


def test_without_the_second_key_it_is_a_dry_run_that_never_passes(told: list[Command], keys: dict[str, Path]) -> None:
    result = drive(keys, with_keys=False)
    assert told == []
    assert result.status == "INCONCLUSIVE"
    assert result.verdicts[0].short.startswith("dry run INCONCLUSIVE: no command reached the car")
    assert result.log.meta["vehicle"]["armed"] is False


def test_with_both_keys_it_drives_once_and_is_called_by_its_stage_alone(
    told: list[Command], keys: dict[str, Path]
) -> None:
    result = drive(keys)
    assert len(told) >= 50
    assert (result.status, result.stage) == ("PASS", "pe")
    assert not keys["arming"].exists()
    with pytest.raises(ArmingRefused, match="no arming file"):
        drive(keys)


def test_an_arming_for_another_scenario_does_not_fit(told: list[Command], keys: dict[str, Path]) -> None:
    keys["arming"].write_text('vehicle = "tabby"\nscenario = "other.xosc"\n')
    with pytest.raises(ArmingRefused, match="arming file"):
        drive(keys)
    assert told == []


def test_without_an_area_it_is_not_armed(told: list[Command], keys: dict[str, Path]) -> None:
    with pytest.raises(ArmingRefused, match="a real car needs a declared area"):
        run(keys["scenario"], stage="pe", vehicle="tabby", ads=Coasting, duration=1.0, arming=keys["arming"])
    assert told == []


def test_what_does_not_pass_on_the_twin_is_not_driven(told: list[Command], keys: dict[str, Path]) -> None:
    path = keys["scenario"].with_name(f"{keys['scenario'].stem}.gates.toml")
    path.write_text('[[gate]]\nmetric = "max_yaw_rate"\nmax = -1\n')
    with pytest.raises(StageError, match="a real car drives only what passed on the twin, and that is FAIL: max_yaw"):
        drive(keys)
    assert told == []
    assert keys["arming"].exists()


def test_in_its_own_world_it_drives_what_passed_in_parallel_with_the_same_settings(
    told: list[Command], keys: dict[str, Path], tmp_path: Path
) -> None:
    with pytest.raises(StageError, match="drives only what passed on stage pe with the same settings"):
        drive(keys, stage="rw")
    arming = keys["arming"].read_text()
    before = drive(keys, log_dir=tmp_path / "runs").folder
    keys["arming"].write_text(arming)
    told.clear()
    with pytest.raises(StageError, match="with the same settings"):
        drive(keys, stage="rw", passed=[before], P={"LQR_q11": 29.0})
    with pytest.raises(StageError, match="with the same settings"):  # another car passed
        drive(keys, stage="rw", vehicle="tabby:2", passed=[before])
    assert told == []
    assert drive(keys, stage="rw", passed=[before]).stage == "rw"


@pytest.mark.nightly
def test_the_reference_stack_that_passed_in_parallel_is_the_same_in_the_cars_own_world(
    told: list[Command], keys: dict[str, Path], tmp_path: Path
) -> None:
    def reference(stage: str, **options: object):  # type: ignore[no-untyped-def]
        arming, envelope = keys["arming"], keys["envelope"]
        given = {"vehicle": "tabby", "duration": 1.0, "arming": arming, "envelope": envelope, **options}
        return run(keys["scenario"], stage=stage, **given)  # type: ignore[arg-type]

    key = keys["arming"].read_text()
    before = reference("pe", log_dir=tmp_path / "runs").folder
    keys["arming"].write_text(key)
    assert reference("rw", passed=[before]).stage == "rw"


def test_in_parallel_execution_the_driver_keeps_the_last_word(told: list[Command], keys: dict[str, Path]) -> None:
    result = run(
        keys["scenario"], stage="pe", vehicle="tabby", ads=Coasting, duration=1.0,
        arming=keys["arming"], envelope=keys["envelope"],
    )  # fmt: skip
    assert (result.stage, result.log.meta["vehicle"]["armed"]) == ("pe", True)


def test_a_real_car_begins_as_it_stands_not_as_the_scenario_has_it(told: list[Command], keys: dict[str, Path]) -> None:
    """The ego of the scenario rolls at 5 m/s: no jump to standstill, no jerk of one."""
    log = drive(keys, vehicle="standing", with_keys=False).log
    assert log.t[0] == 0.0
    assert abs(log["v"]).max() == pytest.approx(0.0, abs=0.01)
    assert told == []


def test_what_is_no_real_car_is_called_by_its_name_and_needs_no_key(told: list[Command], keys: dict[str, Path]) -> None:
    result = drive(keys, vehicle="toy", with_keys=False)
    assert (result.stage, result.status) == ("pe-toy", "PASS")
    with pytest.raises(StageError, match="pe-toy ERROR: a real vehicle is required, toy says it is none"):
        drive(keys, vehicle="toy", require_real=True)


@pytest.mark.parametrize("t", [0.5, pytest.param(0.95, id="in the last step")])
def test_a_car_of_ones_own_tells_of_its_messages_too(
    told: list[Command], keys: dict[str, Path], monkeypatch: pytest.MonkeyPatch, t: float
) -> None:
    """No run with a fault on the wire passes, whoever judges the messages."""
    import mycar_for_tests

    monkeypatch.setattr(mycar_for_tests.Noisy, "AT", t)
    result = drive(keys, vehicle="noisy", with_keys=False)
    assert [(event.element, event.text) for event in result.log.events if event.kind == "wire"] == [
        ("/gnss/fix", "lost 1 messages")
    ]
    assert result.status == "INCONCLUSIVE"


def test_a_car_that_is_lost_ends_the_run_as_an_error_with_the_log_so_far(
    told: list[Command], keys: dict[str, Path], tmp_path: Path
) -> None:
    """Two or three commands a tick: after 25 of them, 0.4 to 0.65 s were driven. Asked to stop, it is lost again."""
    result = drive(keys, vehicle="lost", stage="rw", with_keys=False, log_dir=tmp_path / "runs")
    assert (result.status, result.ending) == ("ERROR", "fault")
    assert result.verdicts[0].short.startswith("run ERROR: the car has been silent for 0.16 s at t=0.")
    assert result.folder is not None
    assert 0.3 < Log.load(result.folder).duration < 0.7
    assert (result.folder / "result.json").is_file()


def test_the_two_keys_are_rehearsed_with_a_car_that_is_not_real(
    told: list[Command], keys: dict[str, Path], tmp_path: Path
) -> None:
    """As with a real one: this vehicle, this scenario, an area, on pe first; used up by the drive."""
    with pytest.raises(ArmingRefused, match="arming file: vehicle = 'tabby', this drive is of 'toy'"):
        drive(keys, vehicle="toy")
    key = keys["arming"].read_text().replace("tabby", "toy")
    keys["arming"].write_text(key)
    with pytest.raises(ArmingRefused, match="a real car needs a declared area: --envelope FILE"):
        run(keys["scenario"], stage="pe", vehicle="toy", ads=Coasting, duration=1.0, arming=keys["arming"])
    with pytest.raises(StageError, match="drives only what passed on stage pe-toy"):
        drive(keys, vehicle="toy", stage="rw")
    assert told == []
    result = drive(keys, vehicle="toy", log_dir=tmp_path / "runs")
    assert (result.status, result.stage, result.log.meta["vehicle"]["armed"]) == ("PASS", "pe-toy", True)
    with pytest.raises(ArmingRefused, match=r"no arming file: .* was used up: write a new one"):
        drive(keys, vehicle="toy")
    keys["arming"].write_text(key)
    assert drive(keys, vehicle="toy", stage="rw", passed=[result.folder]).status == "PASS"


def test_a_key_that_arms_nothing_is_called_so(told: list[Command], keys: dict[str, Path]) -> None:
    (note,) = [note for note in drive(keys, stage="dt").notes if "arming" in note]
    assert note.endswith("arming.toml is not used: stage dt drives the twin")
    assert keys["arming"].exists()


def test_what_is_wrong_with_the_second_key_is_told_before_anyone_waits_for_the_car(
    keys: dict[str, Path], told: list[Command], monkeypatch: pytest.MonkeyPatch
) -> None:
    def wait(*_: object, **__: object) -> None:
        raise AssertionError("it waited for the car")

    monkeypatch.setattr("mycar_for_tests.Car.__init__", wait)
    keys["arming"].write_text('vehicle = "tabby"\n')
    with pytest.raises(ArmingRefused, match=r"found \['vehicle'\], allowed: vehicle and scenario"):
        drive(keys)
    keys["arming"].unlink()
    with pytest.raises(ArmingRefused, match="no arming file"):
        drive(keys)


def test_an_envelope_below_the_starting_speed_is_why_the_gate_braked(
    told: list[Command], keys: dict[str, Path]
) -> None:
    """The ego starts at 5 m/s: beyond 1.1 times 4 m/s it is braked, until 4 m/s it gets no traction."""
    keys["envelope"].write_text("area = [[-50, -50], [1050, -50], [1050, 50], [-50, 50]]\nmax_speed = 4.0\n")
    result = run(keys["scenario"], stage="pe", vehicle="toy", ads=Coasting, duration=1.0, envelope=keys["envelope"])
    said = [note for note in result.notes if note.startswith("guard: ")]
    assert said[0].startswith("guard: braked for 0.")
    assert said[0].endswith("s from t=0.00 s on (far over the highest speed), the envelope allows 4 m/s")


@pytest.mark.parametrize(
    ("vehicle", "says"),
    [
        ("tabi", r"^unknown vehicle 'tabi', did you mean 'tabby'\?"),
        ("lying", "announces that it is not real, and its car says it is"),
        ("none", "str is no Vehicle"),
        ("broken", "cannot be loaded: AttributeError"),
    ],
)
@pytest.mark.usefixtures("told")
def test_an_adapter_that_is_none_is_one_line(keys: dict[str, Path], vehicle: str, says: str) -> None:
    with pytest.raises(StageError, match=says):
        drive(keys, vehicle=vehicle, with_keys=False)


@pytest.mark.usefixtures("told")
def test_what_is_not_known_to_be_none_counts_as_real() -> None:
    assert is_real("rw", "unknown")
    assert is_real("rw", "never_heard_of")
    assert not is_real("dt", "tabby")
    assert not is_real("pe", "surrogate:hidden.toml")
    assert (label("rw", "unknown"), label("pe", "toy")) == ("rw", "pe-toy")


@pytest.mark.usefixtures("told")
def test_repetition_is_refused_by_name() -> None:
    assert not may_repeat("rw", "tabby")
    with pytest.raises(StageError, match="tuning is refused: vehicle 'tabby' is real"):
        refuse_repetition("tuning", "rw", "tabby")
    refuse_repetition("tuning", "dt", "tabby")
    refuse_repetition("tuning", "rw", "surrogate")


def test_dvp_run_drives_one_scenario_of_one_stage(
    told: list[Command], keys: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    path = os.fspath(keys["scenario"])
    for arguments in (["run", path, path, "--stage", "rw"], ["run", path, "--stage", "pe,rw"]):
        assert main([*arguments, "--vehicle", "tabby", "--no-report"]) == 2
        assert "2 drives in a row is refused: vehicle 'tabby' is real" in capsys.readouterr().err
    assert told == []


def test_tuning_is_refused(told: list[Command], keys: dict[str, Path], capsys: pytest.CaptureFixture[str]) -> None:
    study = keys["scenario"].with_name("study.toml")
    study.write_text(
        '[study]\nobjective = "performance"\nstage = "rw"\nvehicle = "tabby"\n'
        f'[[scenario]]\nfile = "{keys["scenario"].name}"\n[parameters]\n"P.LQR_q11" = [20, 30]\n'
    )
    assert main(["tune", os.fspath(study)]) != 0
    assert "tuning is refused: vehicle 'tabby' is real" in capsys.readouterr().err
    assert told == []


def test_a_wrong_envelope_is_told_before_anything_drives(
    told: list[Command], keys: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules["pytest_dvp.drive.run"], "_rehearse", lambda *_: pytest.fail("it drove"))
    keys["envelope"].write_text("area = 1\n")
    for with_keys in (True, False):  # armed, and dry
        more = {} if with_keys else {"envelope": keys["envelope"]}
        with pytest.raises(EnvelopeError, match="area must be a list of at least 3 corners"):
            drive(keys, with_keys=with_keys, **more)
    assert told == []


def test_in_parallel_execution_the_virtual_road_users_are_seen_with_the_effects_of_the_twins_model(
    told: list[Command], scenario: Write, tmp_path: Path
) -> None:
    """A twin that sees everything 2 m too far ahead: so does the car's LiDAR what is rendered into it, and its log says
    so. Another model, or the default one, changes nothing."""
    offset = '[[effect]]\nname = "detection_offset"\n[effect.parameters.x]\nvalue = 2.0\nunit = "m"\n'
    plain = Path(scenarios.path("models/tabby_evo.toml")).read_text(encoding="utf-8")
    nearest, metas = [], []
    for name, text in (("plain.toml", plain), ("offset.toml", plain + "\n" + offset)):
        (tmp_path / name).write_text(text, encoding="utf-8")
        stack = OneTrick(coast)
        result = run(scenario(*WITH_TARGET), stage="pe", vehicle="toy", ads=stack, duration=0.5, model=tmp_path / name)
        scans = [seen.lidar for seen in stack.seen if seen.lidar is not None]
        nearest.append(float(scans[-1].points[:, 0].min()))
        metas.append(result.log.meta["vehicle"].get("mirrored_with"))
    assert nearest[1] - nearest[0] == pytest.approx(2.0, abs=0.1)
    assert metas == [None, {"detection_offset": {"x": 2.0, "y": 0.0}}]
