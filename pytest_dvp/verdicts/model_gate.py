"""Gates of the kind `model`: a vehicle model must answer the log's commands as the car did.

    [[gate]]
    model = "models/car.toml"          # beside or below the gate file; also .py, .fmu or a log
    rmse = { v = 0.3, yaw_rate = 0.02 }
    mncc = { v = 0.99 }
    lag = 0.05
    stages = ["rw"]

Each bound becomes a gate of its own on a metric of pytest_dvp.metrics.model_match. Such a metric may also be named
outright: metric = "open_loop_error", model = "models/car.toml", signal = "v", max = 0.3.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from openscenario.findings import nearest
from pytest_dvp.gap.compare.bound_values import KINDS, wrong_bound
from pytest_dvp.verdicts.gate import STAGES, Gate, Stage
from pytest_dvp.verdicts.requirement import wrong_requirement

METRICS = {"rmse": "open_loop_error", "mncc": "model_mncc", "lag": "model_lag", "gain": "model_gain"}
KEYS = ("model", *KINDS, "stages", "requirement")
CHANNELS = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")

Find = Callable[..., None]
Stages = Callable[[dict[str, Any], str, int | None, str], tuple[Stage, ...] | None]


def read_model_gate(
    table: dict[str, Any],
    element: str,
    head: int | None,
    keys: Mapping[str, int],
    file: str,
    find: Find,
    stages: Stages,
) -> list[Gate]:
    """The gates of one [[gate]] with a model; what is wrong with it goes to `find`, and the result is then empty."""
    wrong = 0

    def complain(code: str, key: str, text: str, **more: str) -> None:
        nonlocal wrong
        wrong += 1
        find(code, keys.get(key, head), f"{element}.{key}" if key else element, text, **more)

    for key in table:
        if key not in KEYS:
            complain("unknown_key", key, f"unknown key {key[:80]!r}", allowed=", ".join(KEYS), hint=nearest(key, KEYS))
    path = model_file(table["model"], Path(file).parent)
    if isinstance(path, str):
        complain("model", "model", path, found=str(table["model"])[:200])
        path = Path()
    bounds: list[tuple[str, str, float]] = []
    for kind in KINDS:
        if kind not in table:
            continue
        value = table[kind]
        entries = value if isinstance(value, dict) else dict.fromkeys(("v", "yaw_rate"), value)
        if not isinstance(value, dict) and kind in ("rmse", "mncc"):
            complain("bound", kind, f"{kind} is bounded by signal", allowed=f"{kind} = {{ v = 0.3 }}")
            continue
        for signal, bound in entries.items():
            if signal not in CHANNELS:
                hint = nearest(signal, CHANNELS)
                allowed = "" if hint else ", ".join(CHANNELS)
                complain("signal", kind, f"unknown signal {signal[:80]!r}", allowed=allowed, hint=hint)
            elif wrong_text := wrong_bound(kind, bound):
                complain("bound", kind, f"{kind} of {signal} {wrong_text}", found=str(bound))
            else:
                bounds.append((kind, signal, float(bound)))
    if not bounds and not wrong:
        complain("no_bound", "", "a gate on a model needs a bound", allowed=", ".join(KINDS))
    if wrong_text := wrong_requirement(table.get("requirement", "none")):
        complain("requirement", "requirement", wrong_text)
    at = stages(table, "stages", keys.get("stages", head), element) if "stages" in table else STAGES
    if wrong or at is None:
        return []
    return [
        Gate(
            METRICS[kind],
            max=None if kind == "mncc" else bound,
            min=bound if kind == "mncc" else None,
            stages=at,
            options={"model": str(path), "signal": signal},
            file=file,
            line=keys.get(kind, head),
            key=kind,
            requirement=str(table.get("requirement", "")),
        )
        for kind, signal, bound in bounds
    ]


def model_file(name: object, folder: Path) -> Path | str:
    """The model's file, or what is wrong with its name: it may not lead out of the gate file's folder."""
    if not isinstance(name, str) or not name.strip():
        return "model must be the name of a file"
    pure = PurePosixPath(name)
    if pure.is_absolute() or ".." in pure.parts or "\\" in name or "\0" in name:
        return "model must be a file beside or below the gate file"
    path = folder / pure
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
        there = path.is_file()
    except OSError:
        return "model must be the name of a file"
    if not inside:
        return "model leads out of the gate file's folder"
    return path if there else "no such model file"
