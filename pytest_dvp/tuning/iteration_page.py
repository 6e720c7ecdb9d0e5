"""The page of an iteration as plain data, for reports/mcrpg.py."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

from pytest_dvp.tuning.iteration_plan import STAGES
from pytest_dvp.tuning.iteration_text import count, headline
from pytest_dvp.tuning.paper_result import TENTH
from pytest_dvp.tuning.result_bounds import LIKENESS, NOISES

CLOSE = ("ego x", "ego y", "steer", "velocity")  # likeness that the figure draws
DRIVE = ("max TTC^-1", "TET", "max jerk", "max yaw rate", "completion time", "lateral RMSE, lane", "lateral RMSE, path")
UNITS = {
    "max TTC^-1": "1/s", "TET": "s", "max jerk": "m/s^3", "max yaw rate": "rad/s", "completion time": "s",
    "lateral RMSE, lane": "m", "lateral RMSE, path": "m",
}  # fmt: skip


def iterate_page(document: Mapping[str, Any]) -> dict[str, Any]:
    """What `reports.mcrpg.write_mcrpg_report` takes, of the document of `dvp iterate --json`."""
    rows, entries = document["bounds"], document["ledger"]
    return {
        "title": f"{document['plan']}: {document['vehicle']}",
        "headline": headline(entries, structure=document["structure"]),
        "count": f"{count(rows)}; ended: {document['ended']}",
        "reached": all(row["holds"] for row in rows),
        "paper": document["preset"] is not None,
        "structure": document["structure"],
        "lacked": _lacked(entries) if document["structure"] else [],
        "parameters": _parameters(entries, own=document.get("ads") is not None),
        "metrics": _metrics(entries),
        "numbers": [entry["number"] for entry in entries],
        "bounds": rows,
        "course": [
            {
                "number": entry["number"],
                "chi2": entry["held_out"]["chi2_per_n"],
                "position": entry["held_out"]["position_at_2s"],
                "position_bound": _bound(entry["held_out"]["position_noise"]),
                "performance": entry["held_out"]["performance"],
                "likeness": {name: entry["held_out"]["likeness"]["dt-rw"].get(name, {}).get("mean") for name in CLOSE},
            }
            for entry in entries
        ],
        "tuned": [
            {"number": entry["number"], "what": what, "course": entry["tuned"].get(what, {}).get("course", [])}
            for entry in entries
            for what in ("S", "P")
            if entry["tuned"].get(what, {}).get("course")
        ],
        "sensitivity": _sensitivity(entries),
        "ledger": [
            {
                "number": e["number"],
                "accepted": e["accepted"] or "nothing",
                "changes": e["changes"],
                "suspicions": [s["sentence"] for s in e["suspicions"]],
                "effects": [
                    f"{n} " + ", ".join(f"{k} = {_text(v)}" for k, v in p.items()) for n, p in e["effects"].items()
                ],
            }
            for e in entries
        ],
    }


def _bound(noise: float | None) -> float | None:
    """Of the position error [m], by the noise of the measured position [m]; None where that is not known."""
    return None if noise is None else NOISES * noise


def _lacked(entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of each iteration: what the diagnosis said of the twin, whether it was taken, and chi^2/N on held-out drives."""
    return [
        {
            "number": now["number"],
            "verdict": now["structure"]["verdict"],
            "effects": now["structure"]["taken"],
            "refusal": now["structure"]["refusal"],
            "taken": "twin" in now["accepted"],
            "before": before["held_out"]["chi2_per_n"],
            "after": now["held_out"]["chi2_per_n"],
        }
        for before, now in itertools.pairwise(entries)
        if now["structure"]
    ]


def _parameters(entries: list[dict[str, Any]], *, own: bool) -> list[dict[str, Any]]:
    """Rows: name, group, unit, a text an iteration (DT; PE; RW where they differ), the paper's 10th.

    own: P is that of a stack of the user's own, of which the paper says nothing.
    """
    from ads.parameters import declaration, preset
    from vehicle.model.simulator_parameters import S_PARAMETERS, preset_s

    rows = []
    for name in entries[0]["P"]["dt"]:
        cells = [_cell([entry["P"][stage][name] for stage in STAGES]) for entry in entries]
        paper, unit = ["", ""], ""
        if not own:
            paper = [_cell([preset(k, stage).as_dict()[name] for stage in STAGES]) for k in (1, 10)]
            unit = declaration(name).unit
        rows.append({"group": "P", "name": name, "unit": unit, "cells": cells, "paper": paper})
    for p in S_PARAMETERS:
        cells = [_cell([entry["S"][p.name]]) if p.name in entry["S"] else "" for entry in entries]
        if any(cells):
            paper = [_cell([preset_s(k)[p.name]]) if p.name in preset_s(k) else "" for k in (1, 10)]
            rows.append({"group": "S", "name": p.name, "unit": p.declaration.unit, "cells": cells, "paper": paper})
    names = dict.fromkeys((n, k) for entry in entries for n, keys in entry["effects"].items() for k in keys)
    for effect, key in names:
        cells = [_cell([e["effects"][effect][key]]) if effect in e["effects"] else "" for e in entries]
        rows.append({"group": "effect", "name": f"{effect} {key}", "unit": "", "cells": cells, "paper": ["", ""]})
    return rows


def _text(value: float | None) -> str:
    """A value of the ledger; None is infinity there: a limit that there is not, a wind that always comes from ahead."""
    return "not set" if value is None else f"{value:.4g}"


def _cell(values: list[float | None]) -> str:
    texts = [_text(v) for v in values]
    return texts[0] if len(set(texts)) == 1 else "; ".join(texts)


def _metrics(entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows: name, unit, three texts an iteration (DT, PE, RW), the paper's 10th. Likeness is that to RW."""
    rows = []
    for name in LIKENESS:
        cells = []
        for entry in entries:
            pairs = entry["held_out"]["likeness"]
            cells.append([_alike(pairs["dt-rw"], name), _alike(pairs.get("pe-rw", {}), name), ""])
        rows.append({"name": f"MNCC {name} to RW", "unit": "", "cells": cells, "paper": _three(TENTH[name], 4)})
    for name in DRIVE:
        cells = [[_mean(entry["held_out"]["metrics"].get(s, {}).get(name)) for s in STAGES] for entry in entries]
        paper = _three(TENTH[name], 3) if name in TENTH else ["", "", ""]
        rows.append({"name": name, "unit": UNITS[name], "cells": cells, "paper": paper})
    return rows


def _alike(pair: Mapping[str, Any], name: str) -> str:
    mncc = pair.get(name, {}).get("mean")
    if mncc is None:
        return "–"
    lag, gain = pair[f"{name}.lag"]["mean"], pair[f"{name}.gain"]["mean"]
    more = "" if lag is None or gain is None else f" ({lag:.2f} s, {100 * gain:.1f} %)"
    return f"{mncc:.5f}{more}"


def _mean(figure: Mapping[str, Any] | None) -> str:
    if figure is None or figure["mean"] is None:
        return "–"
    return f"{figure['mean']:.3g}"


def _three(values: tuple[float, float, float], digits: int) -> list[str]:
    return [f"{v:.{digits}g}" for v in values]


def _sensitivity(entries: list[dict[str, Any]]) -> dict[str, Any] | None:
    """Of P in the last iteration that tuned it: knobs, metrics, mean influence in units of the metric's scale."""
    for entry in reversed(entries):
        found = entry["tuned"].get("P", {}).get("sensitivity")
        if found:
            metrics = list(dict.fromkeys(m for row in found.values() for m in row))
            values = [[row.get(m, {}).get("mean") for m in metrics] for row in found.values()]
            return {"knobs": list(found), "metrics": metrics, "values": values, "number": entry["number"]}
    return None
