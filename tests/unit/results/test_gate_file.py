"""Gate files: what is read, and one clear line with its place for what is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from results_logs import relaxed

from pytest_dvp.verdicts.judging import GateError, check_gates, read_gates
from vehicle.messages import RoadPoint

GOOD = """\
# bounds
[task]
goal = { road = "1", lane = -1, s = 420.0 }
lane = -1

[[gate]]        # first
metric = "max_ttc_inverse"
max = 1.0
stages = ["dt", "pe"]

[[ gate ]]
metric = "mncc"
signal = "v"
between = ["dt", "rw"]
min = 0.995
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "a.gates.toml"


def write(file: Path, text: str) -> Path:
    file.write_text(text, encoding="utf-8")
    return file


def test_gates_are_read_with_their_lines(file: Path) -> None:
    first, second = read_gates(write(file, GOOD)).gates
    assert (first.metric, first.max, first.min, first.stages, first.line) == (
        "max_ttc_inverse",
        1.0,
        None,
        ("dt", "pe"),
        6,
    )
    assert (second.between, second.options, second.min, second.line) == (("dt", "rw"), {"signal": "v"}, 0.995, 11)


def test_a_difference_between_stages_is_read(file: Path) -> None:
    text = gate('metric = "max_jerk"\nbetween = ["dt", "rw"]\nmax_difference = 0.5\ncutoff = 2.0')
    (found,) = read_gates(write(file, text)).gates
    assert (found.between, found.max_difference, found.max, found.options) == (("dt", "rw"), 0.5, None, {"cutoff": 2.0})


def test_task_is_read(file: Path) -> None:
    task = read_gates(write(file, GOOD)).task
    assert task is not None
    assert (task.goal, task.start, task.lane) == (RoadPoint("1", -1, 420.0), None, -1)


def test_header_inside_a_text_is_no_gate(file: Path) -> None:
    text = '[[gate]]\nmetric = "event_started"\nmax = 9\n\nevent = """\n[[gate]]\n"""\n\n[[gate]]\n'
    gates = read_gates(write(file, text + 'metric = "collision"\nmax = 0\n')).gates
    assert [gate.line for gate in gates] == [1, 9]


def test_gates_in_an_inline_array_have_the_line_of_the_array(file: Path) -> None:
    gates = read_gates(write(file, '\ngate = [\n  { metric = "collision", max = 0 },\n]\n')).gates
    assert [gate.line for gate in gates] == [2]


PAIR = 'between = ["dt", "rw"]'


@pytest.mark.parametrize("signal", ["v", "objects.y", "object.Car.vx", "ads.what_my_stack_logs", "gate.steer_cmd"])
def test_signals_of_a_log_are_known_and_those_of_a_stack_may_be_any(signal: str, file: Path) -> None:
    assert read_gates(write(file, gate(f'metric = "mncc"\nmin = 0\nsignal = "{signal}"\n{PAIR}'))).gates


def gate(body: str) -> str:
    return f"[[gate]]\n{body}\n"


@pytest.mark.parametrize(
    ("text", "line", "code", "said"),
    [
        (
            gate('metric = "max_jrk"\nmax = 1'),
            2,
            "unknown_metric",
            "unknown metric 'max_jrk' (did you mean 'max_jerk'?)",
        ),
        (gate('metric = "tet"\nmax = nan'), 3, "bound", "max must be a finite number; found 'nan'"),
        (gate('metric = "tet"\nmax = inf'), 3, "bound", "max must be a finite number; found 'inf'"),
        (gate('metric = "tet"\nmax = "1"'), 3, "bound", "max must be a finite number; found '1'"),
        (gate('metric = "tet"\nmax = true'), 3, "bound", "max must be a finite number; found 'True'"),
        (gate('metric = "tet"'), 1, "no_bound", "a gate needs a bound; allowed: max, min or both"),
        (gate('metric = "tet"\nmax = 1\nmin = 2'), 4, "min_over_max", "min 2 is greater than max 1"),
        (gate("max = 1"), 1, "no_metric", 'a gate needs a metric: metric = "collision"'),
        (gate('metric = "tet"\nmax = 1\nstages = ["dtt"]'), 4, "unknown_stage", "did you mean 'dt'?"),
        (gate('metric = "tet"\nmax = 1\nstages = []'), 4, "stages", "stages must be a list of stages"),
        (gate('metric = "tet"\nmax = 1\nmaxx = 2'), 4, "unknown_key", "did you mean 'max'?"),
        (gate('metric = "tet"\nmax = 1\ncritcal = 2.0'), 4, "unknown_key", "did you mean 'critical'?"),
        (gate('metric = "tet"\nmax = 1\ncritical = nan'), 4, "option", "must be a finite number"),
        (
            gate('metric = "tet"\nmax = 1\ncritical = -2'),
            4,
            "option",
            "'critical' of metric 'tet' must be > 0, found -2",
        ),
        (
            gate('metric = "max_ttc_inverse"\nmax = 1\nresolution = 5'),  # a contact would count as 0.2 1/s
            4,
            "option",
            "must be > 0 and <= 0.1, found 5",
        ),
        (gate('metric = "mncc"\nmin = 0.9\nsignal = "v"'), 1, "between", 'say which, between = ["dt", "rw"]'),
        (gate('metric = "mncc"\nmin = 0.9\nbetween = ["dt", "rw"]'), 1, "option", "needs the option 'signal'"),
        (gate('metric = "tet"\nmax = 1\nbetween = ["dt", "rw"]'), 4, "between", "by how much it may differ"),
        (gate('metric = "tet"\nmax_difference = 1'), 1, "between", "say which, between"),
        (gate('metric = "tet"\nmax_difference = -1\nbetween = ["dt", "rw"]'), 4, "between", "must be >= 0"),
        (gate('metric = "tet"\nmax_difference = 1\nmax = 2\nbetween = ["dt", "rw"]'), 5, "between", "stands alone"),
        (
            gate('metric = "lag"\nsignal = "v"\nmax_difference = 1\nbetween = ["dt", "rw"]'),
            5,
            "between",
            "compares two logs already",
        ),
        (gate('metric = "mncc"\nmin = 0\nsignal = "v"\nbetween = ["dt", "dt"]'), 5, "between", "two different stages"),
        (
            gate(f'metric = "mncc"\nmin = 0\nsignal = 5\n{PAIR}'),
            4,
            "option",
            "option 'signal' of metric 'mncc' must be a word, found 5",
        ),
        (
            gate(f'metric = "mncc"\nmin = 0\nsignal = "yaw_rat"\n{PAIR}'),
            4,
            "unknown_signal",
            "did you mean 'yaw_rate'?",
        ),
        (gate(f'metric = "twin_error"\nmax = 1\nsignal = "objects.x"\n{PAIR}'), 4, "unknown_signal", "allowed: x, y"),
        (gate(f'metric = "lag"\nmax = 1\nsignal = "object.Car.z"\n{PAIR}'), 4, "unknown_signal", "object.NAME.x, y"),
        (gate('metric = "response_lag"\nmax = 1\ncommand = "ster_cmd"'), 4, "unknown_signal", "'steer_cmd'?"),
        (gate('metric = "tet"\nmin = 1\nclean = true'), 4, "clean", "clean must be the scenario's parameters"),
        (gate('metric = "tet"\nmin = 1\nclean = { v = "a" }'), 4, "clean", "clean must be the scenario's parameters"),
        (gate('metric = "tet"\nmin = 1\nstages = ["rw"]\nclean = {}'), 5, "clean", "on no stage but dt"),
        ("", 1, "no_gate", "a file without gates judges nothing"),
        ("gate = 3", 1, "not_a_table", "gates are written as [[gate]] tables"),
        ("\n[gates]\nx = 1", 2, "unknown_key", "unknown table or key 'gates' (did you mean 'gate'?)"),
        ("[[gate]\n", 1, "not_toml", "not TOML: "),
        ('a = "\n', 1, "not_toml", "not TOML: "),
        ("[task]\ngoal = 3\n", 2, "place", "goal must be a place"),
        ('[task]\ngoal = { road = "1", lane = 0, s = 1 }\n', 2, "value", "lane must be a lane id; found '0'"),
        ('[task]\ngoal = { road = "1", lane = 1, s = nan }\n', 2, "value", "s must be a distance; found 'nan'"),
        ('[task]\ngoal = { road = "1", lane = 1, s = -0.5 }\n', 2, "value", "s must be a distance; found '-0.5'"),
        ("[task]\ngoal = { road = 1, lane = 1, s = 3 }\n", 2, "value", "road must be an id in quotes; found '1'"),
        ("[task]\nlane = 1.5\n", 2, "value", "lane must be a lane id; found '1.5'"),
        ("[task]\ngaol = 1\n", 2, "unknown_key", "did you mean 'goal'?"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(text: str, line: int, code: str, said: str, file: Path) -> None:
    finding = check_gates(write(file, text))[0]
    assert (finding.line, finding.code, finding.file) == (line, f"dvp.gates.{code}", str(file))
    assert said in finding.message


EQUAL = [  # two gates of one metric that ask the same, the second at line 5
    ("metric = 'tet'\nmax = 1", "metric = 'tet'\nmax = 1.0"),
    ("metric = 'tet'\nmax = 1", "metric = 'tet'\nmax = 1\nstages = ['dt']"),
    ("metric = 'tet'\nmax = 1", "metric = 'tet'\nmax = 1\ncritical = 2.0"),  # the default
    ("metric = 'event_started'\nevent = 'Brake'\nmin = 1", "metric = 'event_started'\nmin = 1\nevent = 'Brake'"),
    (
        "metric = 'events_fired'\noptional = ['A', 'B']\nmax = 0",
        "metric = 'events_fired'\noptional = ['B', 'A']\nmax = 0",
    ),
    (f"metric = 'mncc'\nsignal = 'v'\nmin = 0.9\n{PAIR}", f"metric = 'mncc'\nsignal = 'v'\nmin = 0.9\n{PAIR}"),
]
DIFFERENT = [
    ("metric = 'tet'\nmax = 1", "metric = 'tet'\nmax = 1\ncritical = 1.5"),
    ("metric = 'tet'\nmax = 1\nstages = ['dt']", "metric = 'tet'\nmax = 1\nstages = ['rw']"),
    ("metric = 'nees'\nmin = 1", "metric = 'nees'\nmax = 1"),
    ("metric = 'event_started'\nevent = 'Brake'\nmin = 1", "metric = 'event_started'\nevent = 'Swerve'\nmin = 1"),
    ("metric = 'max_jerk'\nmax = 4\nstages = ['dt']", "metric = 'max_jerk'\nmax = 6"),  # decides on pe and rw
]


@pytest.mark.parametrize(("first", "second"), EQUAL)
def test_two_equal_gates_are_an_error_at_the_second_one(first: str, second: str, file: Path) -> None:
    (finding,) = check_gates(write(file, gate(first) + gate(second)))
    head = 3 + first.count("\n")  # of the second [[gate]]
    assert (finding.code, finding.severity, finding.line) == ("dvp.gates.equal", "error", head)
    assert "as in line 1, on stage " in finding.message
    with pytest.raises(GateError, match="the same gate on "):
        read_gates(file)


@pytest.mark.parametrize(("first", "second"), DIFFERENT)
def test_gates_that_differ_in_more_than_their_place_are_fine(first: str, second: str, file: Path) -> None:
    assert check_gates(write(file, gate(first) + gate(second))) == ()
    assert len(read_gates(file).gates) == 2


def test_equal_bounds_of_a_model_are_found_as_well(file: Path) -> None:
    (file.parent / "car.toml").write_text("")
    text = gate("model = 'car.toml'\nrmse = { v = 0.3 }")
    assert [finding.code for finding in check_gates(write(file, text + text))] == ["dvp.gates.equal"]


@pytest.mark.parametrize(("bounds", "line"), [(("max = 2", "max = 1"), 1), (("max = 1", "max = 1.5\nmin = -9"), None)])
def test_a_gate_that_can_never_decide_is_a_warning(bounds: tuple[str, str], line: int | None, file: Path) -> None:
    text = "".join(gate(f"metric = 'tet'\n{bound}") for bound in bounds)
    found = [(finding.code, finding.severity, finding.line) for finding in check_gates(write(file, text))]
    assert found == ([("dvp.gates.never_decides", "warning", line)] if line is not None else [])
    assert len(read_gates(file).gates) == 2  # a run takes it


def test_all_defects_are_told_at_once(file: Path) -> None:
    text = gate('metric = "max_jrk"\nmax = 1') + gate('metric = "tet"\nmax = nan')
    assert [finding.line for finding in check_gates(write(file, text))] == [2, 6]


def test_gates_are_counted_from_one_those_of_a_model_as_well(file: Path) -> None:
    (file.parent / "car.toml").write_text("[parameters]\nwheelbase = 2.5\n", encoding="utf-8")
    text = gate('model = "car.toml"') + gate('metric = "tet"\nmax = nan') + gate('model = "car.toml"\nrmse = "a"')
    found = [finding.element for finding in check_gates(write(file, text))]
    assert found == ["gate[1]", "gate[2].max", "gate[3].rmse"]


def test_error_is_one_line_with_file_and_line(file: Path) -> None:
    with pytest.raises(GateError) as caught:
        read_gates(write(file, gate('metric = "max_jrk"\nmax = nan')))
    assert str(caught.value).startswith(f"{file}:2: error dvp.gates.unknown_metric gate[1].metric: unknown metric")
    assert str(caught.value).endswith(f"(and 1 more: dvp check {file})")
    assert "\n" not in str(caught.value)


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(GateError, match=r"absent\.gates\.toml: error dvp\.gates\.unreadable: .*No such file"):
        read_gates(tmp_path / "absent.gates.toml")


def test_file_that_is_not_utf8_has_a_line(file: Path) -> None:
    file.write_bytes(b"# a\n# \xff\n")
    assert [(f.line, f.code) for f in check_gates(file)] == [(2, "dvp.gates.not_utf8")]


def test_deep_nesting_is_a_finding(file: Path) -> None:
    assert check_gates(write(file, "a = " + "[" * 5000 + "]" * 5000))[0].code == "dvp.gates.too_deep"


@relaxed
@given(
    data=st.one_of(st.binary(max_size=60), st.text(alphabet="[]gate=\"max'#{},\n 1.n-", max_size=60).map(str.encode))
)
def test_no_text_raises_anything_but_findings(data: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.getbasetemp() / "noise.gates.toml"
    path.write_bytes(data)
    assert all("\n" not in str(finding) for finding in check_gates(path))


def test_gate_files_that_ship_are_valid(scenarios_dir: Path) -> None:
    files = sorted(scenarios_dir.glob("*.gates.toml"))
    assert [finding for file in files for finding in check_gates(file)] == []


@pytest.mark.parametrize(("length", "told"), [(199, 199), (200, 200), (201, 200), (400, 200)])
def test_of_a_model_that_is_not_there_200_characters_are_told(length: int, told: int, file: Path) -> None:
    name = ("long/" * 100)[: length - 5] + ".toml"
    for bounds in ("rmse = { v = 0.3 }", "metric = 'open_loop_error'\nsignal = 'v'\nmax = 0.3"):
        (finding,) = check_gates(write(file, gate(f"model = '{name}'\n{bounds}")))
        assert (finding.code, finding.line, finding.found) == ("dvp.gates.model", 2, name[:told])


@pytest.mark.parametrize(("length", "told"), [(79, 79), (80, 80), (81, 80), (300, 80)])
def test_of_a_metric_that_is_not_known_80_characters_are_told(length: int, told: int, file: Path) -> None:
    (finding,) = check_gates(write(file, gate(f"metric = '{'x' * length}'\nmax = 1")))
    assert (finding.code, finding.text) == ("dvp.gates.unknown_metric", f"unknown metric '{'x' * told}'")
    assert "max_jerk" in finding.allowed.split(", ")  # near to none, so all are named


@pytest.mark.parametrize(
    ("signal", "allowed", "hint"),
    [("yaw_rat", "", "did you mean 'yaw_rate'?"), ("gap", "x, y, yaw, v, yaw_rate, ax, ay, steer", "")],
)
def test_of_a_signal_that_a_model_does_not_have_the_nearest_is_named_or_else_all(
    signal: str, allowed: str, hint: str, file: Path
) -> None:
    (file.parent / "car.toml").write_text("[parameters]\nwheelbase = 2.5\n", encoding="utf-8")
    (finding,) = check_gates(write(file, gate(f"model = 'car.toml'\nrmse = {{ {signal} = 0.3 }}")))
    assert (finding.code, finding.line, finding.text) == ("dvp.gates.signal", 3, f"unknown signal '{signal}'")
    assert (finding.allowed, finding.hint) == (allowed, hint)


@pytest.mark.parametrize(
    ("metric", "option", "value", "found"),
    [
        ("event_started", "event", "3", "3"),
        ("event_started", "event", '["CutsIn"]', "['CutsIn']"),
        ("nis", "sensor", "true", "True"),
        ("input_age", "sensor", "1.5", "1.5"),
    ],
)
def test_an_option_without_a_default_is_of_its_type(
    file: Path, metric: str, option: str, value: str, found: str
) -> None:
    (finding,) = check_gates(write(file, gate(f'metric = "{metric}"\nmax = 0\n{option} = {value}')))
    assert finding.text == f"option {option!r} of metric {metric!r} must be a word, found {found}"
    assert finding.line == file.read_text().splitlines().index(f"{option} = {value}") + 1


@pytest.mark.parametrize(
    ("wanted", "allowed"),
    [
        ('metric = "nis"\nsensor = "gnss"', "mean, greatest"),
        ('metric = "input_age"\nsensor = "gnss"', "greatest, least"),
        ('metric = "speed_error"', "rms, greatest"),
        ('metric = "tick_time"', "median, p99, worst"),
    ],
)
def test_a_statistic_that_a_metric_does_not_have_is_a_finding(file: Path, wanted: str, allowed: str) -> None:
    (finding,) = check_gates(write(file, gate(f'{wanted}\nmax = 1\nstatistic = "max"')))
    assert finding.text.endswith(f": found 'max', allowed: {allowed}")
