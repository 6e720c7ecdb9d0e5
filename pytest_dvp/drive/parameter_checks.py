"""Values set from outside: names and ranges checked before a run, so that a slip costs one line and not a run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_dvp.drive.assignments import Assignments
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.spelling import unknown

if TYPE_CHECKING:
    from pytest_dvp.drive.chosen_stack import Ads


def declared_names(path: Path) -> tuple[str, ...]:
    """Names of the parameters a scenario file declares. Raises ScenarioError for a broken file."""
    from openscenario.read import read_declarations

    return tuple(declaration.name for declaration in read_declarations(path))


def check_overrides(path: Path, assignments: Assignments, option: str = "--set", ads: Ads | None = None) -> None:
    """Raises SettingError for an unknown name (with the nearest one) or a value outside its range or constraints.

    ads: whose P it is; None: the reference stack
    """
    if assignments.scenario:
        check_declared(path, assignments.scenario, option)
    if assignments.P:
        from pytest_dvp.drive.stack_host import find_ads
        from pytest_dvp.drive.stack_parameters import check_parameters

        check_parameters(ads or find_ads(), assignments.P, option)
    check_simulator_parameters(assignments.S, option)


def check_declared(path: Path, values: Mapping[str, str], option: str = "--set") -> None:
    """Raises SettingError unless a scenario declares `values`, and its types and constraints allow them."""
    from openscenario.findings import shown
    from openscenario.parameters import allows, constraints
    from openscenario.read import read_declarations
    from openscenario.values import BadValue, check_type

    declared = {declaration.name: declaration for declaration in read_declarations(path)}
    for name, value in values.items():
        if name not in declared:
            raise SettingError(f"{option} {name}: {unknown(f'parameter of {path.name}', name, declared)}")
        try:
            check_type(value, declared[name].parameter_type)
        except BadValue as error:  # before the constraints, in which a word is merely outside of a range
            allowed = ", ".join(filter(None, (error.allowed, constraints(declared[name]))))
            raise SettingError(f"{option} {name}: found {shown(value)}, {error.text}; allowed: {allowed}") from None
        if not allows(declared[name], value):
            raise SettingError(f"{option} {name}: found {value}; allowed: {constraints(declared[name])}")


def check_simulator_parameters(values: Mapping[str, str | float], option: str = "--set") -> None:
    """Raises SettingError unless `values` are allowed values of S."""
    if values:
        from vehicle.model.errors import ModelError
        from vehicle.model.simulator_parameters import check_s

        try:
            check_s(values)
        except ModelError as error:
            raise SettingError(f"{option}: {error}") from None
