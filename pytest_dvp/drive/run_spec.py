"""RunSpec: every option of a run, declared once.

From its fields come the pytest options, their ini keys and environment variables, the options of `dvp run`, the command
that repeats a run, the keywords of `pytest_dvp.run()` and the page docs/options.md. A new option is one field here, and
then `python -m scripts.make_run_options`.

Imports the standard library only: the pytest plugin reads it at start-up.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from pytest_dvp.drive.assignments import Assignments
from pytest_dvp.drive.option import OF_A_CAR, option, settings_of
from pytest_dvp.logs.budget import Budget
from pytest_dvp.text.names import REFERENCE

SIMULATED = ("surrogate", "can", "replay")  # vehicles of ours, none of which is a car
RUNS = "runs"  # folder of the run folders, below the root folder


@dataclasses.dataclass(frozen=True)
class RunSpec:
    """The values in force. Times [s]; `runs` and `rootdir` absolute; `origins` of those that were set, by key.

    `replay` and `compared` are places in a row: the words of a printed command keep their order.
    """

    stage: str = option(
        "str",
        "dt",
        "what is driven: dt the twin, pe and rw a car",
        allowed="dt, pe, rw",
        more="dvp run has an option --stage that takes several, pytest a marker for each",
        home="python",
        replay=20,
    )
    seed: int = option(
        "int", 7, "seed of every random number of a run", "N", 0, replay=10, compared=10, always=True, rehearsed=True
    )
    ads: str = option(
        "ads",
        REFERENCE,
        "driving stack: entry point of pytest_dvp.ads, module:Class, FILE.py:Class, ros2:F.toml",
        "NAME",
        more="run() also takes the class or function itself; it is called with (parameters, network, description) if "
        "it takes them, else with nothing, and what it makes needs `tick(observation) -> Command` and may have trace, "
        "path and detections",
        keywords=(("ads", "DriverFactory | Ads | str | None", ""),),
        replay=80,
        compared=50,
    )
    model: Path | None = option(
        "file", None, "vehicle model (TOML); default: the TABBY EVO", "FILE", replay=100, compared=80, rehearsed=True
    )
    effects: tuple[Path, ...] = option(
        "files",
        (),
        "file with your effects that the model uses; it is executed",
        "FILE.py",
        replay=120,
        compared=120,
        rehearsed=True,
    )
    gates: Path | None = option(
        "file",
        None,
        "gate file; default: NAME.gates.toml beside the scenario",
        "FILE",
        more="without that file the default gates hold",
        replay=110,
        compared=90,
        rehearsed=True,
    )
    stage_gates: Path | None = option(
        "file", None, "further gates between stages, for every scenario", "FILE", keyword="", compared=100
    )
    stage_logs: tuple[Path, ...] = option(
        "logs",
        (),
        "log or run folder of a stage driven earlier, to compare with",
        "LOG",
        keywords=(
            (
                "passed",
                "Sequence[str | Path]",
                "run folders of earlier drives: on stage rw a real car drives only what passed on pe in one of them",
            ),
        ),
        compared=110,
    )
    library: tuple[Path, ...] = option(
        "paths",
        (),
        "folder that scenarios may refer to, besides their own and the rootdir",
        "DIR",
        replay=130,
        compared=130,
        rehearsed=True,
    )
    reading: Literal["esmini", "standard"] = option(
        "str",
        "esmini",
        "reading of three rules on which esmini and the standard differ: esmini or standard (docs/conformance.md)",
        "NAME",
        choices=("esmini", "standard"),
        keywords=(("reading", "Reading", ""),),
        replay=140,
        compared=160,
        rehearsed=True,
    )
    roads: Literal["strict", "lenient"] = option(
        "str",
        "lenient",
        "how a faulty road file is read: strict refuses it, lenient repairs what leaves a geometry and a route, and "
        "says what it assumed (docs/roads.md)",
        "NAME",
        choices=("strict", "lenient"),
        keywords=(("roads", "Roads", ""),),
        replay=205,
        compared=195,
        rehearsed=True,
    )
    ego: str | None = option(
        "str", None, "entity that the ADS drives; default: Ego", "NAME", replay=150, compared=140, rehearsed=True
    )
    set: Assignments = option(
        "assignments",
        (),
        "NAME=VALUE of a declared parameter, P.NAME=VALUE (ADS), S.NAME=VALUE",
        "A",
        factory=Assignments,
        keywords=(
            ("parameters", "Mapping[str, str | float | bool] | None", "declared parameters of the scenario, by name"),
            ("P", "Mapping[str, str | float] | None", "parameters of the ADS (its own, if it declares some), by name"),
            ("S", "Mapping[str, str | float] | None", "parameters of the simulator, by name"),
        ),
        replay=90,
        compared=60,
        rehearsed=True,
    )
    cases: int | None = option(
        "int",
        None,
        "number of random cases of a distribution; default: all",
        "N",
        1,
        keyword="",
        stages=("dt",),
    )
    duration: float | None = option(
        "float",
        None,
        "longest simulated time [s]; default: 60, with a goal 300",
        "SECONDS",
        0.05,
        unit="s",
        replay=190,
        compared=150,
        rehearsed=True,
    )
    wall_limit: float = option(
        "float",
        600.0,
        "longest wall time of one run [s]",
        "SECONDS",
        0.1,
        unit="s",
        more="a run that it ends is an ERROR",
    )
    tick_limit: float = option(
        "float",
        10.0,
        "longest wall time of one tick of the stack [s]; six times that for the first one and for loading it",
        "SECONDS",
        0.01,
        unit="s",
        more="a stack that takes longer is ended, and the run is an ERROR",
        replay=180,
        compared=180,
        rehearsed=True,
    )
    stack_process: str | None = option(
        "str",
        None,
        "whether a stack that is given by name runs in a separate process; default: on, for the reference stack off",
        "on|off",
        choices=("on", "off"),
        more="in a process of its own it can be ended whatever it does; a class or an object always runs in this "
        "process, where its Python code is interrupted",
        replay=170,
        compared=170,
    )
    compute_delay: str | None = option(
        "delay",
        None,
        "stage dt: commands reach the car later, and a share of them never: SECONDS[+-JITTER][,drop=SHARE]",
        "DELAY",
        unit="s",
        stages=("dt",),
        replay=160,
    )
    after_collision: float = option(
        "float",
        1.0,
        "simulated time from a collision to the end of the run [s]",
        "SECONDS",
        0.0,
        unit="s",
        replay=200,
        compared=190,
        rehearsed=True,
    )
    vehicle: str = option(
        "str",
        "surrogate",
        "car of stages pe and rw: surrogate or can (:HIDDEN.toml), ros1 (:FILE), replay:LOG, ros2_car:N or yours",
        "NAME",
        more="can is the surrogate with its drive-by-wire on CAN, ros1 the surrogate over ROS 1; a file behind the "
        "colon says what is hidden in it, of ros1 how it is reached; replay is a recording; ros1_car:FILE, "
        "ros2_car:DOMAIN and other adapters are cars",
        stages=OF_A_CAR,
        replay=30,
        compared=20,
    )
    truth: Path | None = option(
        "new_file",
        None,
        "file (.mcap) into which the surrogate of stages pe and rw writes what was true, for grading",
        "F.mcap",
        more="logs of pe and rw hold what its reference system measured; of several drives the last one is kept",
        stages=OF_A_CAR,
    )
    dbc: Path | None = option(
        "file",
        None,
        "messages of a vehicle on CAN, with the signal map next to them; default: those that ship",
        "F.dbc",
        stages=OF_A_CAR,
        replay=40,
        compared=70,
    )
    fault: str | None = option(
        "str",
        None,
        "wire fault to make between surrogate and harness, as drop@5+3 (seconds)",
        "NAME",
        stages=OF_A_CAR,
        replay=50,
        compared=30,
    )
    clock: str = option(
        "str",
        "stepped",
        "time of stages pe and rw: stepped (lock-step) or real (wall clock)",
        "NAME",
        allowed="stepped, real",
        more="before a drive by the wall clock the twin rehearses it, so that everything is loaded; a real car drives "
        "only what passed there",
        stages=OF_A_CAR,
        replay=60,
        compared=40,
    )
    arming: Path | None = option(
        "file",
        None,
        "arming file that permits one run of this vehicle in this scenario; the run renames it to .used",
        "FILE",
        more="without it a real car makes a dry run, which never passes; a surrogate that is given one needs both keys "
        "and an area, too: a rehearsal",
        stages=OF_A_CAR,
    )
    envelope: Path | None = option(
        "file",
        None,
        "file with the area and the highest speed of a real car (TOML: area, max_speed)",
        "FILE",
        stages=OF_A_CAR,
        replay=70,
    )
    max_log_bytes: int | None = option(
        "size",
        None,
        "most that a log unpacks to, as 2GB; default: 200 times its file",
        "BYTES",
        1,
        unit="B",
        home="reading",
    )
    max_log_rows: int | None = option(
        "int", None, "most rows, or messages, of a log; default: 50 million", "N", 1, home="reading"
    )
    max_file_bytes: int | None = option(
        "size",
        None,
        "largest file that is read; default: logs 64 GiB, CSV and .mat 512 MiB, scenarios, roads and catalogues 64 MiB",
        "BYTES",
        unit="B",
        home="reading",
    )
    runs: Path | None = option(
        "path",
        None,
        "folder of the run folders; default: ROOTDIR/runs",
        "DIR",
        keywords=(("log_dir", "str | Path | None", "folder for a numbered run folder; default: nothing is written"),),
    )
    single_file: bool = option("flag", False, "a report of one file: it shares nothing with the other runs (2 MB more)")
    require_real: bool = option(
        "flag", False, "make it an ERROR if a surrogate takes the place of a real vehicle", stages=OF_A_CAR
    )
    scenarios: tuple[Path, ...] = option(
        "paths", (), "folder whose .xosc files are collected, besides those on the command line", "DIR", home="pytest"
    )
    no_diagnosis: bool = option(
        "flag", False, "do not diagnose a model that does not match (a diagnosis takes seconds)", home="pytest"
    )
    campaign: bool = option(
        "flag",
        False,
        "drive many variants of each scenario in place of one on each stage; RUNS/campaign-NAME holds the map",
        home="pytest",
        stages=("dt",),
    )
    campaign_runs: int = option("int", 200, "number of drives of a campaign", "N", 1, home="pytest", stages=("dt",))
    campaign_method: str = option(
        "str",
        "sobol",
        "how the drives of a campaign are chosen: sobol, random, grid, rare or a searcher (docs/campaigns.md)",
        "NAME",
        home="pytest",
        stages=("dt",),
    )
    shard: str | None = option(
        "str", None, "part I of N of a campaign, for CI jobs side by side; `dvp campaign --merge` puts them together",
        "I/N", home="pytest", stages=("dt",),
    )  # fmt: skip
    rootdir: Path = option(
        "path",
        None,
        "folder that scenarios may refer to; files of a stack are looked for in it",
        factory=Path.cwd,
        keywords=(("rootdir", "Path | None", ""),),
        home="python",
        rehearsed=True,
    )
    folder_name: str | None = option(
        "str", None, "what is between number and stage in the name of the run folder; default: the scenario's name",
        home="python",
    )  # fmt: skip
    gated: bool = option(
        "flag", False, "the twin drives behind the guard, as the car of the other stages does",
        home="python", stages=("dt",),
    )  # fmt: skip
    origins: Mapping[str, str] = dataclasses.field(default_factory=dict, compare=False, repr=False)

    def origin(self, name: str) -> str:
        """Where a setting was set, for messages: `--ads`, `environment DVP_ADS`, `pytest.ini: dvp_ads`."""
        return self.origins.get(name.replace("-", "_"), f"--{name}")

    @property
    def runs_folder(self) -> Path:
        """The folder of the run folders: the stated one, else RUNS in the root directory."""
        return self.runs if self.runs is not None else self.rootdir / RUNS

    @property
    def budget(self) -> Budget:
        """How large the logs may be that are read."""
        return Budget(self.max_log_bytes, self.max_log_rows, self.max_file_bytes)

    def keywords(self) -> dict[str, Any]:
        """What `pytest_dvp.run()` is called with, so that these values are in force there."""
        values: dict[str, Any] = {"rootdir": self.rootdir}
        for setting in SETTINGS:
            if setting.kind == "assignments":
                values |= {"parameters": self.set.scenario, "P": self.set.P, "S": self.set.S}
            elif setting.keywords:
                values[setting.keywords[0][0]] = getattr(self, setting.key)
        return {**values, "log_dir": self.runs_folder}


OPTIONS = settings_of(RunSpec)
SETTINGS = tuple(setting for setting in OPTIONS if setting.home in ("run", "reading"))
PLUGIN_SETTINGS = tuple(setting for setting in OPTIONS if setting.home == "pytest")
BUDGET = tuple(setting.name for setting in OPTIONS if setting.home == "reading")
"""How large the logs may be that are read: every command that reads one has these settings."""
OF_A_RUN = tuple(setting.name for setting in OPTIONS if setting.home == "run")
"""The options of `dvp run`, besides those of every command that reads a log."""
