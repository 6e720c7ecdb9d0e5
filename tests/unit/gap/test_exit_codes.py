"""What is wrong has one exit code, whichever command finds it: 2 on the command line, 1 in a file that it names."""

from __future__ import annotations

from pathlib import Path

import pytest
from gap_logs import drive

from pytest_dvp.cli.command_line import main
from tests.truth.generate import write_csv

CAR = '[inputs]\nsteer = "steer_cmd"\nlongitudinal = "accel_cmd"\n[parameters]\nwheelbase = 2.5\nmass = 1200.0\n'

COMMANDS = {
    "compare": "compare LOG --model MODEL",
    "diagnose": "diagnose LOG --model MODEL",
    "extend": "extend --model MODEL --add drive_gain --fit LOG --out new.toml",
    "plan": "plan LOG --model MODEL --out plan",
    "doctor": "doctor LOG --model MODEL",
    "map": "map LOG",
}
LOGS = {"none.csv": 2, "folder": 2, "picture.png": 2, "empty.csv": 1}
UNITLESS = {"bare.csv": 1}  # for which `dvp map` is made
PARTS = {"one.csv@x:y": 2, "one.csv@5:3": 2, "one.csv@90:99": 1}
MODELS = {"none.toml": 2, "folder": 2, "broken.toml": 1, "typo.toml": 1}
OPTIONS = {
    "--nix": 2, "--map none.toml": 2, "--map folder": 2, "--map broken.toml": 1, "--msg none": 2,
    "--effects none.py": 2, "--effects folder": 2, "--effects broken.py": 1,
}  # fmt: skip


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = {
        "car.toml": CAR, "broken.toml": "wheel = ", "typo.toml": "[parameters]\nwheelbse = 2.5\n", "empty.csv": "",
        "bare.csv": "t,v\n0,1\n1,2\n", "picture.png": "", "broken.py": "import nothing_of_this_name\n",
        "nothing.json": '{"effects": []}',
    }  # fmt: skip
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "folder").mkdir()
    write_csv(tmp_path / "one.csv", dict(drive(5.0).columns))
    monkeypatch.chdir(tmp_path)


def words(command: str, *, log: str = "one.csv", model: str = "car.toml", more: str = "") -> list[str]:
    return COMMANDS[command].replace("LOG", log).replace("MODEL", model).split() + more.split()


def gives(code: int, given: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(given) == code, given
    told = capsys.readouterr().err
    assert told
    assert "Traceback" not in told


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(("log", "code"), LOGS.items())
def test_log(command: str, log: str, code: int, capsys: pytest.CaptureFixture[str]) -> None:
    gives(code, words(command, log=log), capsys)


@pytest.mark.parametrize("command", sorted(COMMANDS.keys() - {"map"}))
@pytest.mark.parametrize(("log", "code"), [*UNITLESS.items(), *PARTS.items()])
def test_part_of_a_log_and_log_without_units(
    command: str, log: str, code: int, capsys: pytest.CaptureFixture[str]
) -> None:
    gives(code, words(command, log=log), capsys)


@pytest.mark.parametrize("command", sorted(COMMANDS.keys() - {"map"}))
@pytest.mark.parametrize(("model", "code"), MODELS.items())
def test_model(command: str, model: str, code: int, capsys: pytest.CaptureFixture[str]) -> None:
    gives(code, words(command, model=model), capsys)


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(("option", "code"), OPTIONS.items())
def test_option(command: str, option: str, code: int, capsys: pytest.CaptureFixture[str]) -> None:
    if command == "map" and option.split()[0] in ("--map", "--effects"):  # options that it does not have
        code = 2
    gives(code, words(command, more=option), capsys)


@pytest.mark.parametrize(
    ("given", "code"),
    [
        (words("compare", more="--channels nix"), 2),
        (words("compare", more="--report folder"), 2),
        (words("compare", more="--report none/page.html"), 2),
        (words("diagnose", more="--report folder"), 2),
        (words("diagnose", more="--held-out none.csv"), 2),
        (words("diagnose", more="--plan one.csv"), 2),
        (words("map", more="--out folder"), 2),
        (words("map", more="--out none/map.toml"), 2),
        (words("plan", more="--between nix,mass"), 2),
        (words("plan", more="--only nix"), 2),
        (words("plan", more="--max-speed -1"), 2),
        (words("extend", more="--remove nix"), 2),
        (words("extend", more="--remove mass"), 2),
        (words("extend", more="--gates none.toml"), 2),
        (["extend", "--model", "car.toml", "--from", "none.json", "--fit", "one.csv", "--out", "new.toml"], 2),
        (["extend", "--model", "car.toml", "--from", "nothing.json", "--fit", "one.csv", "--out", "new.toml"], 1),
    ],
    ids=lambda given: " ".join(given) if isinstance(given, list) else str(given),
)
def test_further_option(given: list[str], code: int, capsys: pytest.CaptureFixture[str]) -> None:
    gives(code, given, capsys)


@pytest.mark.parametrize("threads", ["0", "-3", "many"])
def test_threads_that_are_none_are_one_line_before_anything_is_loaded(
    threads: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", threads)
    assert main(["effects"]) == 2
    told = capsys.readouterr().err
    assert told == f"NUMBA_NUM_THREADS: must be a whole number of threads, 1 or more (found {threads!r})\n"
