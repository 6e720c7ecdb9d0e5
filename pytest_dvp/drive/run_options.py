"""RunOptions: the keywords of `pytest_dvp.run()`. Made by `python -m scripts.make_run_options` from RunSpec."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

if TYPE_CHECKING:
    from openscenario.road.repairs import Roads
    from openscenario.storyboard.reading import Reading
    from pytest_dvp.drive.chosen_stack import Ads, DriverFactory


class RunOptions(TypedDict, total=False):
    """What `pytest_dvp.run()` can be told; what is left out has its default."""

    stage: str
    """what is driven: dt the twin, pe and rw a car; dvp run has an option --stage that takes several, pytest a marker
    for each; default: dt."""
    seed: int
    """seed of every random number of a run; default: 7."""
    ads: DriverFactory | Ads | str | None
    """driving stack: entry point of pytest_dvp.ads, module:Class, FILE.py:Class, ros2:F.toml; run() also takes the
    class or function itself; it is called with (parameters, network, description) if it takes them, else with nothing,
    and what it makes needs `tick(observation) -> Command` and may have trace, path and detections; default:
    reference."""
    model: str | Path | None
    """vehicle model (TOML); default: the TABBY EVO."""
    effects: Sequence[str | Path]
    """file with your effects that the model uses; it is executed."""
    gates: str | Path | None
    """gate file; default: NAME.gates.toml beside the scenario; without that file the default gates hold."""
    passed: Sequence[str | Path]
    """run folders of earlier drives: on stage rw a real car drives only what passed on pe in one of them."""
    library: Sequence[str | Path]
    """folder that scenarios may refer to, besides their own and the rootdir."""
    reading: Reading
    """reading of three rules on which esmini and the standard differ: esmini or standard (docs/conformance.md);
    default: esmini."""
    roads: Roads
    """how a faulty road file is read: strict refuses it, lenient repairs what leaves a geometry and a route, and says
    what it assumed (docs/roads.md); default: lenient."""
    ego: str | None
    """entity that the ADS drives; default: Ego."""
    parameters: Mapping[str, str | float | bool] | None
    """declared parameters of the scenario, by name."""
    P: Mapping[str, str | float] | None
    """parameters of the ADS (its own, if it declares some), by name."""
    S: Mapping[str, str | float] | None
    """parameters of the simulator, by name."""
    duration: float | None
    """longest simulated time [s]; default: 60, with a goal 300."""
    wall_limit: float
    """longest wall time of one run [s]; a run that it ends is an ERROR; default: 600."""
    tick_limit: float
    """longest wall time of one tick of the stack [s]; six times that for the first one and for loading it; a stack that
    takes longer is ended, and the run is an ERROR; default: 10."""
    stack_process: str | None
    """whether a stack that is given by name runs in a separate process; default: on, for the reference stack off; in a
    process of its own it can be ended whatever it does; a class or an object always runs in this process, where its
    Python code is interrupted."""
    compute_delay: str | None
    """stage dt: commands reach the car later, and a share of them never: SECONDS[+-JITTER][,drop=SHARE]."""
    after_collision: float
    """simulated time from a collision to the end of the run [s]; default: 1."""
    vehicle: str
    """car of stages pe and rw: surrogate or can (:HIDDEN.toml), ros1 (:FILE), replay:LOG, ros2_car:N or yours; can is
    the surrogate with its drive-by-wire on CAN, ros1 the surrogate over ROS 1; a file behind the colon says what is
    hidden in it, of ros1 how it is reached; replay is a recording; ros1_car:FILE, ros2_car:DOMAIN and other adapters
    are cars; default: surrogate."""
    truth: str | Path | None
    """file (.mcap) into which the surrogate of stages pe and rw writes what was true, for grading; logs of pe and rw
    hold what its reference system measured; of several drives the last one is kept."""
    dbc: str | Path | None
    """stages pe and rw: messages of a vehicle on CAN, with the signal map next to them; default: those that ship."""
    fault: str | None
    """stages pe and rw: wire fault to make between surrogate and harness, as drop@5+3 (seconds)."""
    clock: str
    """time of stages pe and rw: stepped (lock-step) or real (wall clock); before a drive by the wall clock the twin
    rehearses it, so that everything is loaded; a real car drives only what passed there; default: stepped."""
    arming: str | Path | None
    """stages pe and rw: arming file that permits one run of this vehicle in this scenario; the run renames it to .used;
    without it a real car makes a dry run, which never passes; a surrogate that is given one needs both keys and an
    area, too: a rehearsal."""
    envelope: str | Path | None
    """stages pe and rw: file with the area and the highest speed of a real car (TOML: area, max_speed)."""
    log_dir: str | Path | None
    """folder for a numbered run folder; default: nothing is written."""
    single_file: bool
    """a report of one file: it shares nothing with the other runs (2 MB more); default: False."""
    require_real: bool
    """stages pe and rw: make it an ERROR if a surrogate takes the place of a real vehicle; default: False."""
    rootdir: Path | None
    """folder that scenarios may refer to; files of a stack are looked for in it."""
    folder_name: str | None
    """what is between number and stage in the name of the run folder; default: the scenario's name."""
    gated: bool
    """the twin drives behind the guard, as the car of the other stages does; default: False."""
