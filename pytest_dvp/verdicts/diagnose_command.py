"""The command that says why a car is not what its twin is: what a failing gate between stages tells next."""

from __future__ import annotations

import hashlib
import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_dvp.logs.log import Log
from pytest_dvp.text.paths import shown
from scenarios import path as shipped

if TYPE_CHECKING:
    from pytest_dvp.verdicts.judging import Verdict

UNKNOWN = "MODEL.toml"


def gap_command(
    failed: Iterable[Verdict],
    twin: tuple[Log, Path | None],
    measured: tuple[Log, Path | None],
    model: Path | None = None,
    effects: Sequence[Path] = (),
) -> str:
    """`dvp diagnose RUN --model M.toml --twin RUN` for gates that failed between a twin and a car.

    Empty if none did, or the car's log is not in a file.

    twin, measured  log of each with the file or folder it is in
    model, effects  files that the twin was made from, as the user named them, if they are known; else the model is
                    looked for where it is likely to be, by the digest that the twin's log holds
    """
    if (
        all(verdict.status != "FAIL" for verdict in failed)
        or measured[1] is None
        or "toml" not in twin[0].meta.get("model", {})
    ):
        return ""
    file, note = _model_file(twin[0], twin[1], model), ""
    if file is None:
        note = f" ({UNKNOWN}: {twin[0].meta['model'].get('file', 'the model of the twin')}, which is not here)"
    words = ["dvp", "diagnose", shown(measured[1]), "--model", UNKNOWN if file is None else shown(file)]
    words += ["--twin", shown(twin[1])] if twin[1] is not None else []  # what the car saw, beside what the twin did
    words += [word for path in effects for word in ("--effects", shown(path))]
    return shlex.join(words) + note


def _model_file(twin: Log, place: Path | None, given: Path | None) -> Path | None:
    """The file that the twin of a log was made from: of this digest, or nothing."""
    about = twin.meta["model"]
    name = Path(str(about.get("file", ""))).name
    # where models are kept: here, beside the project's scenarios, beside the folder of runs, among those that ship
    folders = [Path(), *(Path(folder) for folder in ("models", "scenarios", "scenarios/models"))]
    folders += [place.absolute().parent.parent] if place is not None else []
    likely = [given] if given is not None else []
    likely += [folder / name for folder in (*folders, shipped("models/tabby_evo.toml").parent)] if name else []
    for file in likely:
        if file.is_file() and hashlib.sha256(file.read_bytes()).hexdigest() == about.get("sha256"):
            return file
    return None
