"""The session of a test: where its scenario paths start, which settings are its defaults, and what it noted."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import pytest

from pytest_dvp.plugin.item_notes import current_item, note, note_variant, settings_of
from pytest_dvp.text.errors import SettingError, is_users_mistake
from pytest_dvp.text.near_path import looked_for
from pytest_dvp.text.paths import shown

if TYPE_CHECKING:
    from pytest_dvp.campaigns.variant import Variant
    from pytest_dvp.drive.result import RunResult
    from pytest_dvp.drive.stage_comparison import StageComparison, StageDrive


class Session:
    """Runs of tests: paths resolved from where the running test stands, the session's settings as defaults."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._settings = settings_of(config)
        self._driven = False  # a real car, in this session

    def __repr__(self) -> str:
        return "run"

    def __call__(self, scenario: str | Path | Variant, **options: Any) -> RunResult:
        """Drive a scenario or one of its variants; see `pytest_dvp.drive.run.run` for the options."""
        __tracebackhide__ = True
        try:
            return self._run(scenario, options)
        except KeyboardInterrupt as interrupt:
            _end_session(interrupt)
        except Exception as error:
            if not is_users_mistake(error):
                raise
            raise error.with_traceback(None) from None  # what is wrong is the line of the test, not one of ours

    def _run(self, scenario: str | Path | Variant, options: dict[str, Any]) -> RunResult:
        from pytest_dvp.campaigns.variant import Variant
        from pytest_dvp.drive.run import run
        from pytest_dvp.text.searching import searching

        node = current_item(self._config)
        variant = scenario if isinstance(scenario, Variant) else None
        path = variant.scenario if variant else self.find(Path(scenario))  # type: ignore[arg-type]
        chosen = self.options(path, options, variant, searched=searching())
        note_variant(node, variant, chosen)
        self._refuse_repetition(chosen, searching())
        shared = getattr(node, "dvp_shared", None)
        if shared is None:
            result = run(path, **chosen)
        else:
            result = shared.own(run_key(path, chosen), lambda: run(path, **chosen))
        note(node, result.as_dict())
        return result

    def _refuse_repetition(self, chosen: Mapping[str, Any], searched: bool) -> None:
        """Of a real car: one drive a session, and none that a search asks for."""
        from pytest_dvp.drive.announced_cars import is_real, refuse_repetition

        stage, vehicle = str(chosen.get("stage", "dt")), str(chosen["vehicle"])
        if not is_real(stage, vehicle):
            return
        if searched:
            refuse_repetition("fuzzing", stage, vehicle)
        if self._driven:
            refuse_repetition("a second drive in one session", stage, vehicle)
        self._driven = True

    def across(self, scenario: str | Path, pair: tuple[str, str]) -> StageComparison:
        """Hold two stages of a scenario against each other: drive what nobody has driven in this session, and judge.

        A log of `--dvp-stage-logs` stands before a drive. No real car is driven for it: only the item of a stage
        drives that. Besides the pair, stages that the session was asked for are in the table.
        """
        __tracebackhide__ = True
        try:
            result = self._across(self.find(Path(scenario)), pair)
        except KeyboardInterrupt as interrupt:
            _end_session(interrupt)
        except Exception as error:
            if not is_users_mistake(error):
                raise
            raise error.with_traceback(None) from None
        note(current_item(self._config), result.as_dict())
        return result

    def _across(self, path: Path, pair: tuple[str, str]) -> StageComparison:
        from pytest_dvp.drive import stage_comparison
        from pytest_dvp.drive.option import STAGES
        from pytest_dvp.plugin.selection import asked_stage

        settings, node = self._settings, current_item(self._config)
        gates = stage_comparison.gates_between(path, settings.gates, settings.stage_gates)
        drives, missing = stage_comparison.earlier(settings.stage_logs, path.name)
        for stage in STAGES:
            if stage in drives or stage in missing or not (stage in pair or asked_stage(stage, self._config)):
                continue
            found = self._drive(path, stage)
            if isinstance(found, str):
                missing[stage] = found
            else:
                drives[stage] = found
        chosen = self.options(path, {})
        about = {
            "scenario": shown(path),
            "line": getattr(node, "dvp_line", 1),
            "seed": settings.seed,
            "ads": next((str(drive.log.meta.get("ads", "")) for drive in drives.values()), settings.ads),
            "set": stage_comparison.assigned(chosen),
            "replay": stage_comparison.replay(path, chosen, pair, settings),
        }
        return stage_comparison.compare_stages(
            drives,
            gates,
            [pair],  # type: ignore[list-item]
            about,
            missing=missing,
            files=stage_comparison.Files(settings.runs_folder, settings.single_file, settings.model, settings.effects),
        )

    def _drive(self, path: Path, stage: str) -> StageDrive | str:
        """The drive of a stage in this session, or why there is none and how to get it."""
        from pytest_dvp.drive.announced_cars import may_repeat
        from pytest_dvp.drive.run import run
        from pytest_dvp.drive.stage_checks import check_asked
        from pytest_dvp.drive.stage_comparison import driven
        from pytest_dvp.drive.stages import StageError
        from vehicle.adapter import VehicleLost

        settings, chosen = self._settings, {**self.options(path, {}), "stage": stage}
        try:
            check_asked(stage, settings)
            shared = getattr(current_item(self._config), "dvp_shared", None)
            again = may_repeat(stage, settings.vehicle)
            if shared is None:
                result = run(path, **chosen) if again else None
            else:
                result = shared.shared(run_key(path, chosen), (lambda: run(path, **chosen)) if again else None)
        except (StageError, VehicleLost) as error:
            return str(error)
        if result is None:
            return f"no drive of stage {stage} in this session, and its own test alone drives a real car: -m {stage}"
        return driven(result)

    def options(
        self, path: Path, options: Mapping[str, Any], variant: Variant | None = None, *, searched: bool = False
    ) -> dict[str, Any]:
        """What `pytest_dvp.drive.run.run` is called with: the session's settings, changed by `options` of one call.

        Raises SettingError for a value of the session that a variant varies.
        """
        settings, options = self._settings, dict(options)
        for name in variant.varied if variant else ():
            if name in settings.set.scenario:  # a variant does not hold what is nominal: another one would be driven
                raise SettingError(f"--dvp-set {name}: the test varies it")
        parameters: dict[str, Any] = dict(_declared_only(path, settings.set.scenario))
        parameters.update(variant.values if variant else {})
        parameters.update(options.pop("parameters", {}))
        defaults = {**settings.keywords(), **({"log_dir": None} if searched else {}), **options}
        defaults["P"] = {**self._session_P(defaults["ads"]), **options.get("P", {})}
        defaults["S"] = {**settings.set.S, **options.get("S", {})}
        return {**defaults, "parameters": parameters}

    def _session_P(self, ads: Any) -> Mapping[str, Any]:
        """P of `--dvp-set`; a stack that a test brings gets of it what it has."""
        settings = self._settings
        if not settings.set.P or ads == settings.ads:
            return settings.set.P
        from pytest_dvp.drive.stack_host import find_ads
        from pytest_dvp.drive.stack_parameters import known_of

        chosen = find_ads(ads, [settings.rootdir], process=settings.stack_process, tick_limit=settings.tick_limit)
        return known_of(chosen, settings.set.P)

    def find(self, path: Path) -> Path:
        """The file meant: absolute, beside the test, below the rootdir, or in a folder of `dvp_scenarios`.

        Raises SettingError naming the folders that were looked in.
        """
        if path.is_absolute():
            if path.is_file():
                return path
            raise SettingError(f"no scenario {path}{looked_for(path)}")
        home = current_item(self._config).path.parent
        folders = dict.fromkeys([home, self._settings.rootdir, *self._settings.scenarios])
        for folder in folders:
            if (folder / path).is_file():
                return folder / path
        looked = ", ".join(str(folder) for folder in folders)
        meant = (looked_for(folder / path).partition("did you mean ")[2] for folder in folders)
        near = next((f"; did you mean {name}" for name in meant if name), "")
        raise SettingError(f"no scenario {path}; looked in {looked}{near}")


def _end_session(interrupt: KeyboardInterrupt) -> NoReturn:
    """End the session as SIGINT does, by one line in the place of a traceback through ours."""
    __tracebackhide__ = True
    said = f"dvp: {interrupt}" if str(interrupt) else "dvp: interrupted"
    # Without the interruption as its cause: pytest would spend seconds on a picture of both tracebacks.
    raise pytest.exit.Exception(said, pytest.ExitCode.INTERRUPTED) from None


def run_key(path: Path, options: Mapping[str, Any]) -> str:
    """Name of a run of this session for `pytest_dvp.plugin.shared_runs`: the file and all that it is called with.

    Parameters of the simulator are no part of a stage with a car of its own.
    """
    from pytest_dvp.plugin.shared_runs import key_of

    told = {key: dict(value) if isinstance(value, Mapping) else value for key, value in options.items()}
    return key_of(str(path.resolve()), sorted(told.items(), key=lambda item: item[0]))


def _declared_only(path: Path, assignments: Mapping[str, str]) -> Mapping[str, str]:
    """Assignments of `--dvp-set` hold for the scenarios that declare the name; that one does, collection checked.

    Raises SettingError for a value outside the constraints.
    """
    if not assignments:
        return {}
    from pytest_dvp.drive.parameter_checks import check_declared, declared_names

    declared = declared_names(path)
    chosen = {name: value for name, value in assignments.items() if name in declared}
    check_declared(path, chosen, "--dvp-set")
    return chosen
