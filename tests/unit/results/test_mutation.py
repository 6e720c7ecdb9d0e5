"""Faults between car and stack, and which of them the gates notice."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest
from results_logs import log_of, track

from pytest_dvp.cli.command_line import main
from pytest_dvp.mutation.catalogue import FAULTS, known_faults
from pytest_dvp.mutation.drives import Outcome
from pytest_dvp.mutation.fault import Fault, Memory
from pytest_dvp.mutation.faulty_stack import FaultyStack
from pytest_dvp.mutation.gate_writer import write_gates
from pytest_dvp.mutation.mutate import Envelope, Judged, Mutation, Proposal, envelopes_of, judge_fault
from pytest_dvp.mutation.needs import BEND, CROSSWALK, GOAL, PEDESTRIAN, SPEED, STOP, met
from pytest_dvp.mutation.words import mutation_lines
from pytest_dvp.verdicts.judging import check_gates, read_gates
from vehicle.messages import Command, GnssFix, LidarScan, Observation, Odometry, Task

STACK = '''
from vehicle.messages import Command

class Cruise:
    """Holds 8 m/s and steers straight; looks at nothing else."""

    def __init__(self, parameters, network, description):
        self.v = 0.0

    def tick(self, observation):
        for one in observation.odometry:
            self.v = one.v
        accel = max(-2.0, min(2.0, 8.0 - self.v))
        return Command(observation.t, 0.0, accel, max(accel, 0.0) / 3.0, max(-accel, 0.0) / 8.0)
'''
XOSC = """<?xml version="1.0"?>
<OpenSCENARIO>
  <FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="straight" author="test"/>
  <CatalogLocations/>
  <RoadNetwork><LogicFile filepath="straight.xodr"/></RoadNetwork>
  <Entities>
    <ScenarioObject name="Ego">
      <Vehicle name="car" vehicleCategory="car">
        <BoundingBox><Center x="1.3" y="0" z="0.75"/><Dimensions width="1.8" length="4.2" height="1.5"/></BoundingBox>
        <Performance maxSpeed="50" maxAcceleration="4" maxDeceleration="8"/>
        <Axles>
          <FrontAxle maxSteering="0.5" wheelDiameter="0.6" trackWidth="1.6" positionX="2.6" positionZ="0.3"/>
          <RearAxle maxSteering="0" wheelDiameter="0.6" trackWidth="1.6" positionX="0" positionZ="0.3"/>
        </Axles>
        <Properties/>
      </Vehicle>
    </ScenarioObject>
  </Entities>
  <Storyboard>
    <Init><Actions><Private entityRef="Ego">
      <PrivateAction><TeleportAction><Position>
        <LanePosition roadId="1" laneId="-1" s="10" offset="0"/>
      </Position></TeleportAction></PrivateAction>
    </Private></Actions></Init>
    <StopTrigger><ConditionGroup><Condition name="end" delay="0" conditionEdge="none"><ByValueCondition>
      <SimulationTimeCondition value="10" rule="greaterThan"/>
    </ByValueCondition></Condition></ConditionGroup></StopTrigger>
  </Storyboard>
</OpenSCENARIO>
"""
ROAD = """<?xml version="1.0"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="6" name="straight"/>
  <road name="r" length="500" id="1" junction="-1">
    <planView><geometry s="0" x="0" y="0" hdg="0" length="500"><line/></geometry></planView>
    <lanes><laneSection s="0"><center><lane id="0" type="none" level="false"/></center>
      <right><lane id="-1" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right>
    </laneSection></lanes>
  </road>
</OpenDRIVE>
"""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "cruise.py").write_text(STACK)
    (tmp_path / "straight.xosc").write_text(XOSC)
    (tmp_path / "straight.xodr").write_text(ROAD)
    (tmp_path / "straight.gates.toml").write_text('# kept\n[[gate]]\nmetric = "collision"\nmax = 0\n')
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_planted_escaper_is_found_and_a_gate_kills_it(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A gate on collisions alone notices no wheel speed that is 5 % off, on an empty road."""
    asked = [
        "mutate",
        "straight.xosc",
        "--ads",
        "cruise.py:Cruise",
        "--clean-seeds",
        "3",
        "--cache",
        "kept",
        "--jobs",
        "1",
    ]
    asked += ["--fault", "wheel_speed_plus_5_percent", "camera_wrong_class", "--json"]
    assert main([*asked, "--write"]) == 1
    found = {one["name"]: one for one in json.loads(capsys.readouterr().out)["faults"]}
    assert found["wheel_speed_plus_5_percent"]["escaped"]
    assert found["wheel_speed_plus_5_percent"]["proposed"]["false_alarm_rate"] == pytest.approx(1.0 / 4.0)
    assert not found["camera_wrong_class"]["changed"]
    text = (project / "straight.gates.toml").read_text()
    assert text.startswith("# kept\n")
    assert "proposed by dvp mutate" in text
    assert main(asked) == 0
    again = {one["name"]: one for one in json.loads(capsys.readouterr().out)["faults"]}
    assert again["wheel_speed_plus_5_percent"]["killed_by"]
    assert again["camera_wrong_class"]["killed_by"] == []


def test_the_stack_of_the_ini_file_is_driven_and_named(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (project / "pytest.ini").write_text("[pytest]\ndvp_ads = cruise.py:Cruise\n")
    asked = ["mutate", "straight.xosc", "--clean-seeds", "2", "--cache", "kept", "--jobs", "1", "--json"]
    asked += ["--fault", "drive_cut_2s"]
    main(asked)
    of_ini = capsys.readouterr()
    assert of_ini.err.startswith("dvp mutate: 1 scenario, stage dt, ADS cruise.py:Cruise (pytest.ini: dvp_ads)\n")
    main([*asked, "--no-ini", "--ads", "cruise.py:Cruise"])
    named = capsys.readouterr()
    assert named.err.startswith("dvp mutate: 1 scenario, stage dt, ADS cruise.py:Cruise\n")
    assert json.loads(named.out) == json.loads(of_ini.out)  # of the reference stack, the numbers are others


@pytest.mark.nightly
def test_what_was_driven_is_not_driven_again(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["mutate", "straight.xosc", "--ads", "cruise.py:Cruise", "--clean-seeds", "2", "--cache", "kept"]
    asked += ["--fault", "drive_cut_2s"]
    main(asked)
    first = capsys.readouterr().out
    files = {file: file.read_bytes() for file in (project / "kept").rglob("*.json")}
    assert len(files) == 3
    spoilt, *whole = files
    spoilt.write_bytes(files[spoilt][:40])
    before = [file.stat().st_mtime_ns for file in whole]
    main(asked)
    assert capsys.readouterr().out == first
    assert json.loads(spoilt.read_text())["status"] == json.loads(files[spoilt])["status"]
    assert [file.stat().st_mtime_ns for file in whole] == before


@pytest.mark.nightly
def test_the_source_of_the_stack_is_changed_too(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["mutate", "straight.xosc", "--ads", "cruise.py:Cruise", "--clean-seeds", "2", "--cache", "kept", "--json"]
    assert main([*asked, "--fault", "drive_cut_2s", "--source", "cruise.py", "--mutants", "6"]) == 1
    found = [one for one in json.loads(capsys.readouterr().out)["faults"] if one["where"] == "source"]
    assert len(found) == 6
    assert all(one["name"].startswith("source cruise.py ") for one in found)
    assert any(one["escaped"] for one in found)


def test_a_map_is_another_one_for_the_stack_alone() -> None:
    signals = (SimpleNamespace(name="a"), SimpleNamespace(name="b"))
    network = SimpleNamespace(signals=signals, roads={"1": 1}, lane_width=lambda road, lane, s: 3.0)
    maps = known_faults()["map_without_lights"].maps
    narrow = known_faults()["map_lanes_70_percent_wide"].maps
    assert maps is not None
    assert narrow is not None
    assert (maps(network).signals, maps(network).roads) == ((), {"1": 1})
    assert narrow(network).lane_width("1", -1, 0.0) == pytest.approx(2.1)
    assert network.signals == signals


def test_a_late_task_comes_two_seconds_late() -> None:
    inner = Recorder()
    stack = FaultyStack(inner, known_faults()["task_2s_late"])
    for k in range(60):
        stack.tick(Observation(t=0.05 * k, task=Task(set_speed=5.0) if k == 3 else None))
    assert [k for k, seen in enumerate(inner.seen) if seen.task is not None] == [43]


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (["--source", "nowhere.py"], "--source: no file 'nowhere.py'"),
        (["--mutants", "0"], "--mutants is 0, expected a whole number >= 1"),
        (["--fault", "gnss_frosen"], "gnss_frozen"),
        (["--clean-seeds", "1"], "--clean-seeds is 1, expected a whole number >= 2"),
        (["--jobs", "0"], "--jobs is 0, expected a whole number >= 1"),
        (["--ads", "cruse.py:Cruise"], "--ads: no file"),
    ],
)
def test_a_wrong_option_is_one_line(
    project: Path, option: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["mutate", "straight.xosc", "--ads", "cruise.py:Cruise", *option]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line


def observation(k: int) -> Observation:
    points = np.array([[5.0, 1.0, 0.5], [20.0, -2.0, 0.5], [40.0, 0.0, 0.5]])
    return Observation(
        t=0.05 * k, gnss=(GnssFix(0.05 * k, float(k), 2.0, 0.1, 0.0),), odometry=(Odometry(0.05 * k, 10.0, 0.0),),
        lidar=LidarScan(0.05 * k, points),
    )  # fmt: skip


class Recorder:
    """Keeps what it sees and steers by the tick."""

    def __init__(self) -> None:
        self.seen: list[Observation] = []

    def tick(self, observation: Observation) -> Command:
        self.seen.append(observation)
        return Command(observation.t, 0.01 * len(self.seen), -1.0, 0.0, 0.2)


def through(name: str, ticks: int = 8) -> tuple[list[Observation], list[Command]]:
    inner = Recorder()
    stack = FaultyStack(inner, known_faults()[name])
    sent = [stack.tick(observation(k)) for k in range(ticks)]
    return inner.seen, sent


def test_faults_do_what_their_names_say() -> None:
    assert [o.gnss[0].x for o in through("gnss_late_200ms")[0]] == [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0]
    assert through("wheel_speed_plus_5_percent")[0][3].odometry[0].v == pytest.approx(10.5)
    assert [c.steer for c in through("command_late_100ms")[1]] == pytest.approx(
        [0.01, 0.01, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06]
    )
    stale = [c.steer for c in through("command_every_fifth_stale")[1]]
    assert stale == pytest.approx([0.01, 0.02, 0.03, 0.04, 0.04, 0.06, 0.07, 0.08])
    assert [c.t for c in through("command_late_100ms")[1]] == pytest.approx([0.05 * k for k in range(8)])
    points = through("lidar_nan_in_a_band")[0][0].lidar
    assert points is not None
    assert [math.isnan(x) for x in points.points[:, 0]] == [False, True, False]
    near = through("lidar_blind_beyond_15m")[0][0].lidar
    assert near is not None
    assert len(near.points) == 1
    old = through("stamps_100ms_old")[0][4]
    assert (old.t, old.odometry[0].t) == pytest.approx((0.2, 0.1))
    assert through("brake_half")[1][0].brake == pytest.approx(0.1)
    assert {round(c.steer, 6) for c in through("steer_in_steps_of_2deg")[1]} <= {0.0, 0.034907, 0.069813}


def test_a_freeze_begins_after_five_seconds_and_stays() -> None:
    seen, _ = through("gnss_frozen", 300)
    assert [o.gnss[0].x for o in seen[:100]] == [float(k) for k in range(100)]
    assert {o.gnss[0].x for o in seen[100:]} == {100.0}


def test_the_clean_message_is_never_changed() -> None:
    for fault in FAULTS:
        one, memory = observation(150), Memory()
        memory.observations.extend(observation(k) for k in range(100, 151))
        memory.tick = 150
        before = repr(one.gnss) + repr(one.lidar.points.tolist() if one.lidar else "")
        if fault.sees is not None:
            fault.sees(one, memory)
        assert repr(one.gnss) + repr(one.lidar.points.tolist() if one.lidar else "") == before, fault.name


def test_there_are_more_than_forty_and_each_has_its_name_once() -> None:
    assert len(FAULTS) >= 40
    assert len(known_faults()) == len(FAULTS)


def test_outside_an_envelope_is_measured_in_its_width() -> None:
    envelope = Envelope(1.0, 2.0, 20)
    assert [envelope.beyond(v) for v in (1.0, 1.5, 2.0)] == [0.0, 0.0, 0.0]
    assert envelope.beyond(2.5) == pytest.approx(0.5)
    assert envelope.beyond(0.0) == pytest.approx(1.0)


def clean_outcomes() -> list[Outcome]:
    """Twenty clean drives: a distance of 1.00 to 1.19 m, a headway, and an age that some gate asked with an option."""
    return [Outcome("PASS", {}, {"min_distance": 1.0 + 0.01 * k, "pet": 2.0, "input_age": 0.1}) for k in range(20)]


def test_no_gate_is_proposed_of_a_metric_that_asks_for_an_option() -> None:
    envelopes = envelopes_of(clean_outcomes())
    assert set(envelopes) == {"min_distance", "pet"}


def test_an_escaper_that_only_takes_a_metric_away_has_a_gate_that_kills_it() -> None:
    outcome = Outcome("PASS", {}, {"min_distance": 1.05, "pet": None})
    found = judge_fault(
        Fault("blind", "observation"), {"a.xosc": outcome}, {"a.xosc": envelopes_of(clean_outcomes())}, {}
    )
    assert found.escaped
    assert found.proposed is not None
    assert (found.proposed.scenario, found.proposed.metric, found.proposed.max) == ("a.xosc", "pet", None)
    assert found.proposed.min is not None
    assert found.proposed.min < 2.0  # what clean drives keep, on the side that is worse
    assert not found.proposed.habit


def test_the_proposed_bound_lies_half_way_to_the_fault() -> None:
    outcome = Outcome("PASS", {}, {"min_distance": 0.8, "pet": 2.0})
    found = judge_fault(
        Fault("near", "observation"), {"a.xosc": outcome}, {"a.xosc": envelopes_of(clean_outcomes())}, {}
    )
    assert found.proposed is not None
    assert (found.proposed.metric, found.proposed.min) == ("min_distance", pytest.approx(0.9))
    assert found.proposed.false_alarm_rate == pytest.approx(1.0 / 21.0)


def proposal_for(metrics: dict[str, float | None], clean: dict[str, float]) -> Proposal | None:
    """Of a fault after which the metrics are these, where all clean drives had those."""
    envelopes = {"a.xosc": envelopes_of([Outcome("PASS", {}, clean)] * 20)}
    return judge_fault(Fault("f", "observation"), {"a.xosc": Outcome("PASS", {}, metrics)}, envelopes, {}).proposed


def test_a_bound_that_forbids_better_driving_is_proposed_only_where_nothing_else_notices_and_as_a_habit() -> None:
    clean = {"missed_objects": 30.0, "max_jerk": 2.0, "nees": 1.0}
    better_and_worse = proposal_for({"missed_objects": 0.0, "max_jerk": 2.2, "nees": 1.0}, clean)
    assert better_and_worse is not None
    assert (better_and_worse.metric, better_and_worse.max, better_and_worse.habit) == (
        "max_jerk", pytest.approx(2.1), False,
    )  # fmt: skip
    better_alone = proposal_for({"missed_objects": 0.0, "max_jerk": 2.0, "nees": 1.0}, clean)
    assert better_alone is not None
    assert (better_alone.metric, better_alone.min, better_alone.habit) == ("missed_objects", 15.0, True)
    neither = proposal_for({"missed_objects": 30.0, "max_jerk": 2.0, "nees": 0.5}, clean)  # too unsure
    assert neither is not None
    assert (neither.metric, neither.min, neither.habit) == ("nees", 0.75, False)


def test_no_bound_is_looser_than_the_default_gate_of_its_metric() -> None:
    clean = {"road_departure": 0.0, "scenario_ended": 1.0}
    off = proposal_for({"road_departure": 23.0, "scenario_ended": 1.0}, clean)
    assert off is not None
    assert (off.metric, off.max, off.habit) == ("road_departure", 0.0, False)
    endless = proposal_for({"road_departure": 0.0, "scenario_ended": 0.0}, clean)
    assert endless is not None
    assert (endless.metric, endless.min) == ("scenario_ended", 1.0)
    # clean drives leave the road themselves: no bound on it can be a gate
    assert proposal_for({"road_departure": 23.0}, {"road_departure": 1.0}) is None


def test_a_habit_is_written_as_a_bound_of_clean_drives_with_the_parameters_they_had(tmp_path: Path) -> None:
    declared = '<ParameterDeclarations><ParameterDeclaration name="gap" parameterType="double" value="8.5"/>'
    declared += '<ParameterDeclaration name="who" parameterType="string" value="Lead"/></ParameterDeclarations>'
    scenario = tmp_path / "straight.xosc"
    scenario.write_text(XOSC.replace("<CatalogLocations/>", f"{declared}<CatalogLocations/>"))
    proposals = [
        Proposal(str(scenario), "max_jerk", 0.9, None, 0.05, habit=True),
        Proposal(str(scenario), "max_jerk", None, 3.0, 0.05),
    ]
    (file,) = write_gates(proposals)
    assert check_gates(file) == ()  # meant so: no warning
    habit, bound = read_gates(file).gates[-2:]
    assert (habit.min, habit.max, habit.stages, habit.only_with) == (0.9, None, ("dt",), {"gap": 8.5})
    assert (bound.min, bound.max, bound.only_with) == (None, 3.0, None)


def test_what_only_habits_notice_is_told() -> None:
    envelopes = {"a.xosc": envelopes_of([Outcome("PASS", {}, {"max_jerk": 2.0})] * 20)}
    gates = {"max_jerk >= 1.00 m/s^3": "FAIL", "tet <= 0.00 s": "PASS"}
    outcome = Outcome("FAIL", gates, {"max_jerk": 0.5}, clean=["max_jerk >= 1.00 m/s^3"])
    found = judge_fault(Fault("f", "observation"), {"a.xosc": outcome}, envelopes, {})
    assert found.by_habit
    (line, *_) = mutation_lines(Mutation((found,), ("a.xosc",), 20, {}))
    assert line.startswith(
        "1 of 1 faults that change a drive are noticed by a gate, 1 of them by bounds of clean drives"
    )
    both = dataclasses.replace(outcome, gates={**gates, "tet <= 0.00 s": "FAIL"})
    assert not judge_fault(Fault("f", "observation"), {"a.xosc": both}, envelopes, {}).by_habit


def test_a_fault_without_effect_has_a_reason_only_where_one_is_known() -> None:
    """What the stack does not read comes before what the drives lack; what they met is no reason."""
    names = ("camera_no_pedestrians", "blind", "map_without_lights", "gnss_doubled", "steer_limited_10deg")
    judged = tuple(Judged(known_faults()[name], False, (), 0.0, "", None) for name in names)
    found = Mutation(judged, ("a.xosc",), 20, {}, frozenset({PEDESTRIAN, BEND}), frozenset({"gnss", "lidar"}))
    lines = mutation_lines(found)
    assert lines[lines.index("no scenario excites:") + 1 :] == [
        "  camera_no_pedestrians (your stack does not read camera)",
        "  blind (needs a road user in its way)",
        "  map_without_lights (needs a traffic light that it meets at red)",
        "  gnss_doubled",
        "  steer_limited_10deg",
    ]
    assert dataclasses.replace(found, reads=None).why_idle(judged[0].fault) == ""


def test_each_fault_of_a_sensor_names_it() -> None:
    assert [fault.name for fault in FAULTS if fault.where == "observation" and not fault.of] == [
        "signals_lost", "signals_all_green",  # which every stack is given
    ]  # fmt: skip
    assert {name for fault in FAULTS for name in fault.of} == {"gnss", "odometry", "imu", "lidar", "camera"}


def test_what_a_drive_met_is_told_from_its_log() -> None:
    t = 0.01 * np.arange(1001)
    crossing = np.array([[30.0, -2.0], [33.0, -2.0], [33.0, 2.0], [30.0, 2.0]])
    walker = track(t[::5], 40.0, 3.0)
    walker = dataclasses.replace(walker, kind="pedestrian")
    v = np.where(t < 8.0, 5.0, 0.0)
    columns = {"v": v, "x": np.minimum(5.0 * t, 40.0), "y": 0.0, "yaw": 0.0}
    task = {"route": [], "set_speed": 5.0}
    straight = log_of(columns=columns, objects={"a": walker}, meta={"task": task})
    straight = dataclasses.replace(straight, road=[{"kind": "crosswalk", "points": crossing}])
    assert set(met(straight, {"stop_line": None, "goal_reached": 1.0})) == {PEDESTRIAN, STOP, CROSSWALK, GOAL, SPEED}
    turning = log_of(columns={**columns, "v": 5.0, "y": 50.0, "yaw": 0.1 * t})
    turning = dataclasses.replace(turning, road=[{"kind": "crosswalk", "points": crossing}])
    assert met(turning, {}) == [BEND]


def test_of_two_proposals_the_tighter_one_is_written(tmp_path: Path) -> None:
    scenario = str(tmp_path / "a.xosc")
    proposals = [
        Proposal(scenario, "max_jerk", None, 3.0, 0.05), Proposal(scenario, "max_jerk", None, 2.5, 0.05),
        Proposal(scenario, "completion_time", 10.0, None, 0.05),
    ]  # fmt: skip
    (file,) = write_gates(proposals)
    text = file.read_text()
    assert "max = 2.5" in text
    assert "max = 3" not in text
    assert "min = 10" in text
    gates = read_gates(file).gates  # a new file takes the place of the gates that hold without one
    assert [gate.metric for gate in gates[:3]] == ["collision", "road_departure", "scenario_ended"]
    assert {gate.stages for gate in gates[3:]} == {("dt",)}


def test_every_second_message_is_one_of_those_that_came() -> None:
    """A LiDAR of 10 Hz has a scan in every second tick of 20 Hz."""
    fault, memory, seen = next(f for f in FAULTS if f.name == "lidar_every_second"), Memory(), []
    assert fault.sees is not None
    for tick in range(20):
        memory.tick = tick
        scan = LidarScan(0.05 * tick, np.zeros((1, 3))) if tick % 2 else None
        seen.append(fault.sees(msgspec.structs.replace(observation(tick), lidar=scan), memory).lidar is not None)
    assert [tick for tick, there in enumerate(seen) if there] == [1, 5, 9, 13, 17]


def test_what_else_a_stack_offers_stays_its_own() -> None:
    inner: Any = SimpleNamespace(tick=lambda o: Command(0.0, 0.0, 0.0, 0.0, 0.0), trace={"a": 1.0})
    assert FaultyStack(inner, FAULTS[0]).trace == {"a": 1.0}


def test_gates_between_stages_alone_leave_the_default_gates_to_be_written(tmp_path: Path) -> None:
    file = tmp_path / "a.gates.toml"
    file.write_text('[[gate]]\nmetric = "lateral_rmse"\nmax_difference = 0.2\nbetween = ["dt", "rw"]\n')
    write_gates([Proposal(str(tmp_path / "a.xosc"), "max_jerk", None, 2.5, 0.05)])
    assert [gate.metric for gate in read_gates(file).gates] == [
        "lateral_rmse", "collision", "road_departure", "scenario_ended", "max_jerk",
    ]  # fmt: skip
    write_gates([Proposal(str(tmp_path / "a.xosc"), "max_ttc_inverse", None, 1.0, 0.05)])
    assert [gate.metric for gate in read_gates(file).gates].count("collision") == 1
