"""Projects for the plugin's tests: small valid scenarios, and a fake `run` that drives nothing."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

XODR = """<?xml version="1.0"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="6" name="straight" date="2026-01-01T00:00:00"/>
  <road name="straight" length="1000" id="1" junction="-1">
    <link/>
    <planView><geometry s="0" x="0" y="0" hdg="0" length="1000"><line/></geometry></planView>
    <lanes><laneSection s="0">
      <left><lane id="1" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></left>
      <center><lane id="0" type="none" level="false"/></center>
      <right><lane id="-1" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right>
    </laneSection></lanes>
  </road>
</OpenDRIVE>
"""

HEAD = '<FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="test" author="test"/>'

XOSC = f"""<?xml version="1.0" encoding="UTF-8"?>
<OpenSCENARIO>
  {HEAD}
  <ParameterDeclarations>
    <ParameterDeclaration name="ego_speed" parameterType="double" value="5.0">
      <ConstraintGroup>
        <ValueConstraint rule="greaterOrEqual" value="2.0"/>
        <ValueConstraint rule="lessOrEqual" value="6.0"/>
      </ConstraintGroup>
    </ParameterDeclaration>
  </ParameterDeclarations>
  <CatalogLocations/>
  <RoadNetwork><LogicFile filepath="straight.xodr"/></RoadNetwork>
  <Entities>
    <ScenarioObject name="Ego">
      <Vehicle name="car" vehicleCategory="car" mass="730">
        <BoundingBox>
          <Center x="1.18" y="0" z="0.69"/><Dimensions width="1.488" length="3.03" height="1.38"/>
        </BoundingBox>
        <Performance maxSpeed="30" maxAcceleration="3" maxDeceleration="6"/>
        <Axles>
          <FrontAxle maxSteering="0.349" wheelDiameter="0.57" trackWidth="1.3" positionX="2.36" positionZ="0.28"/>
          <RearAxle maxSteering="0" wheelDiameter="0.57" trackWidth="1.3" positionX="0" positionZ="0.28"/>
        </Axles>
      </Vehicle>
    </ScenarioObject>
  </Entities>
  <Storyboard>
    <Init><Actions><Private entityRef="Ego">
      <PrivateAction><TeleportAction>
        <Position><LanePosition roadId="1" laneId="-1" s="10"/></Position>
      </TeleportAction></PrivateAction>
      <PrivateAction><LongitudinalAction><SpeedAction>
        <SpeedActionDynamics dynamicsShape="step" value="0" dynamicsDimension="time"/>
        <SpeedActionTarget><AbsoluteTargetSpeed value="$ego_speed"/></SpeedActionTarget>
      </SpeedAction></LongitudinalAction></PrivateAction>
    </Private></Actions></Init>
    <StopTrigger><ConditionGroup><Condition name="end" delay="0" conditionEdge="none">
      <ByValueCondition><SimulationTimeCondition value="3" rule="greaterThan"/></ByValueCondition>
    </Condition></ConditionGroup></StopTrigger>
  </Storyboard>
</OpenSCENARIO>
"""

CATALOG = f"""<?xml version="1.0" encoding="UTF-8"?>
<OpenSCENARIO>{HEAD}<Catalog name="empty"/></OpenSCENARIO>
"""

# A run that drives nothing and passes, or fails one gate if the scenario's name says so.
FAKE_RUN = """
import pathlib
import pytest
from pytest_dvp.plugin.item_notes import current_item, note


class Result:
    def __init__(self, path, stage, seed, status):
        self.status, self.seed = status, seed
        self.plain = {
            "scenario": pathlib.Path(path).name, "line": 40, "stage": stage, "seed": seed, "status": status,
            "ending": "stop", "simulated": 3.0, "set": {}, "folder": None, "error": None,
            "replay": f"dvp run {pathlib.Path(path).name} --seed {seed}",
            "metrics": {"max_ttc_inverse": 1.31 if status == "FAIL" else 0.25},
            "verdicts": [{
                "gate": "max_ttc_inverse <= 1.00 1/s", "metric": "max_ttc_inverse", "status": status,
                "value": 1.31 if status == "FAIL" else 0.25, "unit": "1/s", "bound": 1.0,
                "margin": -0.31 if status == "FAIL" else 0.75, "t": 7.42, "object": "Target",
                "short": "max_ttc_inverse 1.31 1/s > 1.00 at t=7.42 s (Target)" if status == "FAIL"
                         else "max_ttc_inverse 0.25 1/s <= 1.00 at t=7.42 s (Target)",
                "message": "max_ttc_inverse 1.31 1/s > 1.00 at t=7.42 s (Target), margin -0.31 1/s, gate x.toml:3",
                "file": "x.gates.toml", "line": 3,
            }],
        }

    def as_dict(self):
        return self.plain


@pytest.fixture(scope="session")
def run(request):
    def drive(scenario, *, stage="dt", seed=7, **options):
        result = Result(scenario, stage, seed, "FAIL" if "bad" in str(scenario) else "PASS")
        note(current_item(request.config), result.as_dict())
        return result

    return drive
"""


def write_scenario(folder: Path, name: str = "good.xosc", text: str = XOSC) -> Path:
    """A scenario and its road in `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "straight.xodr").write_text(XODR)
    path = folder / name
    path.write_text(text)
    return path


class Snapshot:
    """In the place of pytester's: inner sessions forget their own test modules only.

    numpy and numba cannot be loaded twice in a process, and the rest would be slow every time.
    """

    def __init__(self, preserve: object = None) -> None:
        self.saved = dict(sys.modules)

    def restore(self) -> None:
        for name, module in list(sys.modules.items()):
            if name not in self.saved and f"{os.sep}pytest-of-" in str(getattr(module, "__file__", "")):
                del sys.modules[name]
        sys.modules.update(self.saved)


@pytest.fixture(autouse=True)
def keep_libraries(monkeypatch: pytest.MonkeyPatch) -> None:
    """Must come before pytester, which takes its first snapshot when it is made."""
    monkeypatch.setattr("_pytest.pytester.SysModulesSnapshot", Snapshot)


@pytest.fixture(autouse=True)
def bare(keep_libraries: None, pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    """Inner sessions without plugins that cost more than a test and have no part in it."""
    monkeypatch.setenv("PYTEST_ADDOPTS", "-p no:benchmark -p no:pytest_cov -p no:hypothesispytest")
    for name in ("GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def project(pytester: pytest.Pytester) -> pytest.Pytester:
    """A project with good.xosc, bad.xosc, a catalogue and the fake `run`."""
    pytester.makeini("[pytest]\naddopts = --strict-markers --strict-config -W error -p no:cacheprovider")
    pytester.makeconftest(FAKE_RUN)
    write_scenario(pytester.path, "good.xosc")
    write_scenario(pytester.path, "bad.xosc")
    (pytester.path / "catalog.xosc").write_text(CATALOG)
    return pytester
