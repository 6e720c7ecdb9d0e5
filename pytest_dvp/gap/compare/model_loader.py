"""The model that the option --model names: a model file, a Python step, an FMU or a second log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
from pytest_dvp.gap.compare.compared_model import ComparedModel, CompareError, LogSubject, ModelSubject


def load_compared_model(
    argument: str,
    effects: Mapping[str, Effect] | None = None,
    *,
    mapping: Path | None = None,
    msg_dirs: Sequence[Path] = (),
) -> ComparedModel:
    """What the option --model names: M.toml, step.py (or step.py:function), model.fmu, else a second log.

    `effects`: those of the user's own by name, which M.toml may use beside the catalogue's.
    `mapping`, `msg_dirs`: how to read a second log, as of read_log, but the mapping only as far as it fits; its
    warnings are in `.findings` of the subject.

    Raises CompareError, ModelError or LogError, the last also for a log that the doctor finds errors in.
    """
    extra = tuple((effects or {}).values())
    path, _, function = argument.partition(".py:")
    if function or argument.endswith(".py"):
        from pytest_dvp.gap.compare.python_model import StepSubject, load_step

        step = load_step(Path(path + ".py" if function else argument), function or "step")
        return StepSubject(step, Path(argument).name, extra)
    if argument.endswith(".toml"):
        from vehicle.model.model_file import read_model

        return ModelSubject(read_model(argument, extra=effects), Path(argument).name, extra)
    if argument.endswith(".fmu"):
        if not Path(argument).is_file():
            raise CompareError(f"{argument}: no such file")
        from pytest_dvp.gap.compare.fmu_model import FmuSubject

        return FmuSubject(Path(argument), extra)
    from pytest_dvp.doctor import read_checked_log

    log, findings = read_checked_log(argument, output=True, partial=True, mapping=mapping, msg_dirs=msg_dirs)
    return LogSubject(log, Path(argument).name, findings, extra)
