"""A campaign without a simulator: which points fail is known on paper.

Run as a script it drives and is killed (SIGKILL) during its n-th drive:  python planted.py FOLDER RUNS N
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.crew import LocalCrew
from pytest_dvp.campaigns.one_drive import Drive
from pytest_dvp.campaigns.parameter_space import space_of
from pytest_dvp.campaigns.sampling import sample
from pytest_dvp.campaigns.store import Row, Store
from pytest_dvp.drive.run_spec import RunSpec

XOSC = """<OpenSCENARIO>
  <FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="planted" author="test"/>
  <ParameterDeclarations>
    {}
  </ParameterDeclarations>
  <CatalogLocations/><RoadNetwork/><Entities/>
  <Storyboard><Init><Actions/></Init><StopTrigger/></Storyboard>
</OpenSCENARIO>
"""
PARAMETER = """<ParameterDeclaration name="{}" parameterType="double" value="0.5"><ConstraintGroup>
      <ValueConstraint rule="greaterOrEqual" value="0"/><ValueConstraint rule="lessOrEqual" value="1"/>
    </ConstraintGroup></ParameterDeclaration>"""


def scenario(folder: Path, names: str = "ab") -> Path:
    """A scenario with these parameters, each 0.5 and between 0 and 1."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "planted.xosc"
    path.write_text(XOSC.format("\n    ".join(PARAMETER.format(name) for name in names)), encoding="utf-8")
    return path


def row(order: Drive, objective: float | None, gate: str = "gap >= 0", vacuous: bool = False) -> Row:
    """The row of a drive with this objective; None is INCONCLUSIVE."""
    verdict = "INCONCLUSIVE" if objective is None else "FAIL" if objective < 0.0 else "PASS"
    return Row(
        order.key, order.scenario, order.parameters, 7, verdict, {gate: objective}, {}, vacuous, 0.01, "", "",
        order.base, order.purpose, objective, "" if objective is None else gate, "", f"{gate} {verdict}",
    )  # fmt: skip


def corner(order: Drive) -> Row:
    """Fails where a + b > 1.8: a share of 0.02 of the square."""
    return row(order, 1.8 - float(order.parameters["a"]) - float(order.parameters["b"]))


def deadly(order: Drive) -> Row:
    """Ends its process where a > 0.9."""
    if float(order.parameters["a"]) > 0.9:
        os.kill(os.getpid(), signal.SIGKILL)
    return corner(order)


def campaign(folder: Path, store: Store, work: Callable[[Drive], Row] = corner, names: str = "ab") -> Campaign:
    """The campaign of `work` in a store; the scenario lies in `folder`."""
    settings = RunSpec()
    return Campaign(space_of(scenario(folder, names), settings), settings, store, LocalCrew(1, work))


def main() -> None:
    folder, runs, last = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    done = 0

    def mortal(order: Drive) -> Row:
        nonlocal done
        done += 1
        if done == last:
            os.kill(os.getpid(), signal.SIGKILL)
        with (folder / "driven.txt").open("a") as file:
            file.write(f"{order.key}\n")
        return corner(order)

    with Store(folder / "out", writes=True) as store:
        one = campaign(folder, store, mortal)
        one.rows(sample("random", one.space.axes, runs, 7), "sample")


if __name__ == "__main__":
    main()
