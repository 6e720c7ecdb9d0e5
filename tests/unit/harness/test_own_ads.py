"""A driving stack of one's own: found by name, asked for `tick` only, named wherever a result is."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.drive.run import run
from pytest_dvp.drive.stack_faults import AdsError
from pytest_dvp.drive.stack_host import find_ads, make_driver
from vehicle.messages import Command, Observation

Write = Callable[..., Path]
DOCS = Path(__file__).parents[3] / "docs" / "your-ads.md"
EXAMPLE = re.search(r"```python\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)


class Straight:
    """Nothing but what is required."""

    def tick(self, observation: Observation) -> Command:
        return Command(observation.t, 0.0, 0.0, 0.0, 0.0)


class Asking(Straight):
    def __init__(self, parameters: object, network: object, description: object) -> None:
        self.given = (parameters, network, description)


class Tuning(Straight):
    """Options of its own are not the three things."""

    def __init__(self, gain: float = 1.0, horizon: float = 2.0, weight: float = 3.0) -> None:
        self.given = (gain, horizon, weight)


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    monkeypatch.chdir(tmp_path)


def offer(folder: Path, monkeypatch: pytest.MonkeyPatch, value: str) -> None:
    """An installed package with an entry point `mine`."""
    info = folder / "site" / "somebody-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: somebody\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[pytest_dvp.ads]\nmine = {value}\n")
    monkeypatch.syspath_prepend(str(folder / "site"))


def test_the_example_of_the_docs_drives(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    scenario()
    assert EXAMPLE is not None
    Path("my_stack.py").write_text(EXAMPLE[1])
    assert main(["run", "x.xosc", "--ads", "my_stack.py:Stack", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["status"], result["ads"]) == ("PASS", "my_stack.py:Stack")
    assert result["replay"] == "dvp run x.xosc --seed 7 --ads my_stack.py:Stack"
    assert json.loads(Path(result["folder"], "result.json").read_text())["ads"] == "my_stack.py:Stack"


def test_an_entry_point_is_found_by_its_name(scenario: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    offer(tmp_path, monkeypatch, f"{__name__}:Straight")
    result = run(scenario(), ads="mine")
    assert (result.ads, result.log.meta["ads"], result.status) == ("mine", "mine", "PASS")
    assert result.replay.endswith("--ads mine")


def test_the_reference_stack_is_the_default_and_not_in_the_replay(scenario: Write) -> None:
    result = run(scenario())
    assert (result.ads, "--ads" in result.replay) == ("reference", False)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("mnie", "--ads: unknown ADS 'mnie', did you mean 'mine'?"),
        ("mine", "ads: entry point 'mine' (no_such_module_of_ours:Stack) cannot be loaded: ModuleNotFoundError"),
        ("my_stack.py:Stak", "unknown class 'Stak', did you mean 'Stack'?"),
        ("my_stack.py", "name the class in it, as in my_stack.py:Stack"),
        ("nowhere.py:Stack", "--ads: no file"),
        ("my_stak.py:Stack", "did you mean 'my_stack.py'?"),
        ("broken.py:Stack", "cannot be loaded: ZeroDivisionError: division by zero (broken.py:1)"),
    ],
)
def test_a_wrong_name_is_one_line_and_exit_2(
    name: str,
    says: str,
    scenario: Write,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    offer(tmp_path, monkeypatch, "no_such_module_of_ours:Stack")
    scenario()
    Path("my_stack.py").write_text("class Stack: ...\n")
    Path("broken.py").write_text("1 / 0\n")
    assert main(["run", "x.xosc", "--ads", name]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line
    assert not Path("runs").exists()


def test_a_factory_that_takes_three_things_gets_them() -> None:
    driver = make_driver(find_ads(Asking), "P", "road", "car")
    assert driver._driver.given == ("P", "road", "car")


def test_a_factory_with_options_of_its_own_gets_nothing() -> None:
    driver = make_driver(find_ads(Tuning), "P", "road", "car")
    assert driver._driver.given == (1.0, 2.0, 3.0)


def test_a_factory_that_takes_something_else_is_one_line() -> None:
    with pytest.raises(AdsError, match=r"takes neither \(parameters, network, description\) nor nothing"):
        make_driver(find_ads(lambda one: one), "P", "road", "car")


def test_something_without_tick_is_one_line() -> None:
    class Mute: ...

    with pytest.raises(AdsError, match="has no method tick"):
        make_driver(find_ads(Mute), "P", "road", "car")


@pytest.mark.parametrize(
    ("returned", "says"),
    [
        (None, "tick returned None, expected a vehicle.messages.Command"),
        ((0.0, 1.0), "tick returned (0.0, 1.0) (tuple), expected"),
        (Command(0.0, float("nan"), 0.0, 0.0, 0.0), "a Command with steer = nan (float), expected finite numbers"),
        (Command(0.0, "0", 0.0, 0.0, 0.0), "a Command with steer = '0' (str), expected numbers"),  # type: ignore[arg-type]
        (Command(0.0, 0.0, 0.0, None, []), "with throttle = None, brake = [] (list), expected numbers"),  # type: ignore[arg-type]
        (Command(None, 0.0, 0.0, 0.0, 0.0), "a Command with t = None, expected numbers"),  # type: ignore[arg-type]
        (Command(0.0, 0.0, 0.0, 0.0, 10**400), "(int), expected numbers"),
    ],
)
def test_a_tick_without_a_command_is_one_line(scenario: Write, returned: object, says: str) -> None:
    class Wrong:
        def tick(self, observation: Observation) -> object:
            return returned

    result = run(scenario(), ads=Wrong)
    assert (result.status, result.ending) == ("ERROR", "fault")
    assert result.error is not None
    assert says in result.error
    assert "\n" not in result.error


def test_a_stack_that_no_command_line_can_name_has_no_replay_command(scenario: Write) -> None:
    result = run(scenario(), ads=lambda *_: Straight())
    assert result.replay.startswith("no command line can name the ADS ")
    assert "dvp run" not in result.replay


def test_a_class_given_as_an_object_is_named_where_it_stands(scenario: Write) -> None:
    module = sys.modules[__name__]
    result = run(scenario(), ads=Straight)
    home = f"{module.__name__}" if module.__package__ else str(module.__file__)
    assert result.replay.endswith(f"--ads {home}:Straight")


@pytest.mark.parametrize(
    ("offered", "says"),
    [
        ({"trace": {"a": "x"}}, "trace has 'a': 'x' (str), expected names with numbers"),
        ({"trace": {5: 1.0}}, "trace has 5: 1.0 (float), expected names with numbers"),
        ({"trace": 3}, "trace is 3 (int), expected names with numbers"),
        ({"path": "no"}, "path is 'no' (str), expected an array (n, 2): x, y [m]"),
        ({"detections": 5}, "detections is 5 (int), expected vehicle.messages.Detection in a list"),
        ({"detections": ["car"]}, "detections is ['car'] (list), expected vehicle.messages.Detection in a list"),
    ],
)
def test_what_a_stack_offers_in_another_form_is_one_line(
    scenario: Write, offered: dict[str, object], says: str
) -> None:
    class Offers:
        def __init__(self) -> None:
            self.__dict__.update(offered)

        def tick(self, observation: Observation) -> Command:
            return Command(observation.t, 0.0, 0.0, 0.0, 0.0)

    result = run(scenario(), ads=Offers)
    assert result.status == "ERROR"
    assert result.error is not None
    assert result.error.endswith(says)
    assert "\n" not in result.error


def test_a_stack_that_ends_the_program_is_no_pass(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    path = scenario()
    stack = "import sys\n\nclass Stack:\n    def tick(self, observation):\n        sys.exit(0)\n"
    Path("ends.py").write_text(stack)
    Path("loads.py").write_text("import sys\nsys.exit(0)\n")
    assert main(["run", str(path), "--no-report", "--ads", "ends.py:Stack"]) == 1
    assert "ADS ends.py:Stack: tick ended the program: SystemExit: 0 (ends.py:5)" in capsys.readouterr().out
    assert main(["run", str(path), "--no-report", "--ads", "loads.py:Stack"]) == 2
    assert "loads.py:Stack cannot be loaded: SystemExit: 0 (loads.py:2)" in capsys.readouterr().err
    assert main(["effects", "--effects", "loads.py"]) == 1
    assert capsys.readouterr().err == "dvp: a file that was loaded ended the program: sys.exit(0)\n"


def test_a_stack_that_fails_at_its_end_keeps_what_it_drove(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    class Fails:
        def tick(self, observation: Observation) -> Command:
            return Command(observation.t, 0.0, 0.0, 0.0, 0.0)

        def close(self) -> None:
            raise RuntimeError("boom")

    result = run(scenario(), ads=Fails, duration=0.5)
    assert result.log.duration == pytest.approx(0.5)
    assert "Fails: close: RuntimeError: boom" in capsys.readouterr().err
