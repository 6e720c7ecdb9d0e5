"""The session of a test: where its scenario paths start, which settings are its defaults, and what it noted."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from pytest_dvp.fixtures import current_item, note, note_variant, settings_of
from pytest_dvp.settings import SettingError, is_users_mistake

if TYPE_CHECKING:
    from pytest_dvp.run import RunResult
    from pytest_dvp.variant import Variant


class Session:
    """Runs of tests: paths resolved from where the running test stands, the session's settings as defaults."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._settings = settings_of(config)

    def __repr__(self) -> str:
        return "run"

    def __call__(self, scenario: str | Path | Variant, **options: Any) -> RunResult:
        """Drive a scenario or one of its variants; see `pytest_dvp.run.run` for the options."""
        __tracebackhide__ = True
        try:
            return self._run(scenario, options)
        except Exception as error:
            if not is_users_mistake(error):
                raise
            raise error.with_traceback(None) from None  # what is wrong is the line of the test, not one of ours

    def _run(self, scenario: str | Path | Variant, options: dict[str, Any]) -> RunResult:
        from pytest_dvp.run import run
        from pytest_dvp.variant import Variant, searching

        settings, node = self._settings, current_item(self._config)
        variant = scenario if isinstance(scenario, Variant) else None
        path = variant.scenario if variant else self.find(Path(scenario))  # type: ignore[arg-type]
        parameters: dict[str, Any] = dict(_declared_only(path, settings.set.scenario))
        parameters.update(variant.values if variant else {})
        parameters.update(options.pop("parameters", {}))
        defaults: dict[str, Any] = {
            "seed": settings.seed,
            "model": settings.model,
            "effects": settings.effects,
            "gates": settings.gates,
            "library": settings.library,
            "rootdir": settings.rootdir,
            "ego": settings.ego,
            "ads": settings.ads,
            "vehicle": settings.vehicle,
            "dbc": settings.dbc,
            "require_real": settings.require_real,
            "duration": settings.duration,
            "wall_limit": settings.wall_limit,
            "after_collision": settings.after_collision,
            "log_dir": None if searching() else settings.runs_folder,
        }
        defaults.update(options)
        defaults["P"] = {**settings.set.P, **defaults.get("P", {})}
        defaults["S"] = {**settings.set.S, **defaults.get("S", {})}
        note_variant(node, variant, {**defaults, "parameters": parameters})
        result = run(path, parameters=parameters, **defaults)
        note(node, result.as_dict())
        return result

    def find(self, path: Path) -> Path:
        """The file meant: absolute, beside the test, below the rootdir, or in a folder of `dvp_scenarios`.

        Raises SettingError naming the folders that were looked in.
        """
        if path.is_absolute():
            if path.is_file():
                return path
            raise SettingError(f"no scenario {path}")
        home = current_item(self._config).path.parent
        folders = dict.fromkeys([home, self._settings.rootdir, *self._settings.scenarios])
        for folder in folders:
            if (folder / path).is_file():
                return folder / path
        looked = ", ".join(str(folder) for folder in folders)
        raise SettingError(f"no scenario {path}; looked in {looked}")


def _declared_only(path: Path, assignments: Mapping[str, str]) -> Mapping[str, str]:
    """Assignments of `--dvp-set` hold for the scenarios that declare the name; that one does, collection checked.

    Raises SettingError for a value outside the constraints.
    """
    if not assignments:
        return {}
    from pytest_dvp.override import check_declared, declared_names

    declared = declared_names(path)
    chosen = {name: value for name, value in assignments.items() if name in declared}
    check_declared(path, chosen, "--dvp-set")
    return chosen
