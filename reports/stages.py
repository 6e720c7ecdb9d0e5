"""The page of a comparison of stages: the gates between them, the paper's table, and the drives over each other.

Safe in the same way as the run report: data reaches the page through Jinja's escaping or as escaped JSON.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.figures import BLUE, GREEN, ORANGE, Figure, numbers, thin
from reports.frame import frame
from reports.templating import environment
from reports.verdicts import STATUS_SIGNS, headline, pretty_unit, rows
from reports.whole_file import write_page

COLOURS = {"dt": ORANGE, "pe": GREEN, "rw": BLUE}
DASHES = {"dt": "solid", "pe": "dash", "rw": "solid"}
COURSES = (  # column, what the axis says, unit
    ("v", "speed", "m/s"),
    ("steer", "road-wheel<br>angle", "rad"),
    ("steer_cmd", "wanted<br>angle", "rad"),
    ("yaw_rate", "yaw rate", "rad/s"),
    ("ax", "acceleration<br>along", "m/s²"),
)
POINTS = 1500  # a curve

Courses = Mapping[str, Mapping[str, NDArray[np.float64]]]


def write_stages_report(
    path: str | Path, result: Mapping[str, Any], courses: Courses, library: str | None = None
) -> None:
    """Write the page; same input, same bytes. The file appears whole or not at all.

    result   {"status", "scenario", "stage", "seed", "verdicts": [mapping], "table": mapping or None, "logs": {stage:
             place}, "notes": [str], "replay"} as Across.as_dict of pytest_dvp.drive.stage_comparison makes it
    courses  columns of each drive by stage: equally long arrays t [s], x, y [m], v [m/s], ... NaN = not measured
    library  address of the drawing library relative to the page; None: in the page itself

    Raises OSError if the file cannot be written.
    """
    write_page(path, render_stages_report(result, courses, library))


def render_stages_report(result: Mapping[str, Any], courses: Courses, library: str | None = None) -> str:
    """The page as text; arguments as in `write_stages_report`."""
    verdicts = rows(result.get("verdicts", ()))
    figures = {"path": path_figure(courses), "time": time_figure(courses)} if courses else {}
    text: str = _template().render(
        result=result,
        sign=STATUS_SIGNS.get(str(result.get("status")), "?"),
        signs=STATUS_SIGNS,
        headline=headline(str(result.get("status", "")), verdicts),
        rows=verdicts,
        table=result.get("table"),
        figures=figures,
        unshown=_unshown(result.get("not_validated", ())),
        **frame(figures, ["compare.js"], ["run.css", "compare.css"], library),
    )
    return text


def _unshown(not_validated: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """What the drives could not show, a row an effect and reason: several pairs of stages mostly lack the same."""
    found: dict[tuple[str, str], dict[str, Any]] = {}
    for one in not_validated:
        row = found.setdefault((one["parameter"], one["needs"]), {**one, "pairs": []})
        row["pairs"].append(" and ".join(one["between"]))
    return list(found.values())


def path_figure(courses: Courses) -> Figure:
    """The driven paths from above, one over the other."""
    traces: list[Figure] = []
    for stage, columns in courses.items():
        known = np.flatnonzero(np.isfinite(columns["x"]) & np.isfinite(columns["y"]))
        known = known[:: max(1, len(known) // POINTS)]
        traces.append({
            "type": "scatter", "mode": "lines", "name": stage, "x": numbers(columns["x"][known], 3),
            "y": numbers(columns["y"][known], 3), "line": _line(stage), "showlegend": True,
            "text": [f"{stage}, t = {t:.1f} s" for t in columns["t"][known]], "hoverinfo": "text",
        })  # fmt: skip
    return {
        "data": traces,
        "layout": {
            "height": 420, "margin": {"l": 56, "r": 0, "t": 8, "b": 40}, "hovermode": "closest", "dragmode": "pan",
            "font": {"size": 11.5, "family": "system-ui, sans-serif"},
            "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom"},
            "xaxis": {"title": {"text": "x [m]"}, "zeroline": False},
            "yaxis": {"title": {"text": "y [m]"}, "scaleanchor": "x", "zeroline": False},
        },
    }  # fmt: skip


def time_figure(courses: Courses) -> Figure:
    """A row a signal, a line a stage, each on its own clock."""
    shown = [row for row in COURSES if any(_is_told(columns, row[0]) for columns in courses.values())]
    traces: list[Figure] = []
    for k, (column, _, unit) in enumerate(shown):
        for stage, columns in courses.items():
            if not _is_told(columns, column):
                continue
            t, value = thin(columns["t"], columns[column], POINTS)
            traces.append({
                "type": "scatter", "mode": "lines", "name": stage, "legendgroup": stage, "showlegend": k == 0,
                "x": numbers(t, 3), "y": numbers(value, 5), "xaxis": "x", "yaxis": f"y{k + 1}" if k else "y",
                "line": _line(stage), "connectgaps": False,
                "hovertemplate": f"{stage} %{{y:.4g}} {unit}<extra></extra>",
            })  # fmt: skip
    return {"data": traces, "layout": _layout(shown, max(float(c["t"][-1]) for c in courses.values() if len(c["t"])))}


def _layout(shown: Sequence[tuple[str, str, str]], end: float) -> Figure:
    height, gap = 116.0, 14.0
    total = len(shown) * (height + gap)
    layout: Figure = {
        "height": round(total + 84), "margin": {"l": 92, "r": 10, "t": 34, "b": 44}, "hovermode": "x",
        "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom"}, "dragmode": "zoom", "showlegend": True,
        "font": {"size": 11.5, "family": "system-ui, sans-serif"},
        "xaxis": {"title": {"text": "time [s]"}, "range": [0.0, end], "zeroline": False, "anchor": "free",
                  "position": 0},
    }  # fmt: skip
    top = total
    for k, (_, label, unit) in enumerate(shown):
        layout[f"yaxis{k + 1}" if k else "yaxis"] = {
            "domain": [max(top - height, 0.0) / total, top / total], "anchor": "x", "nticks": 5, "fixedrange": True,
            "zeroline": True, "title": {"text": f"{label}<br>[{unit}]", "standoff": 6},
        }  # fmt: skip
        top -= height + gap
    return layout


def _line(stage: str) -> Figure:
    name = stage.split("-")[0]
    return {"color": COLOURS.get(name, BLUE), "dash": DASHES.get(name, "solid"), "width": 1.6}


def _is_told(columns: Mapping[str, NDArray[np.float64]], name: str) -> bool:
    return name in columns and bool(np.isfinite(columns[name]).any())


@cache
def _template() -> Any:
    made = environment()
    made.filters["unit"] = pretty_unit
    made.filters["short"] = lambda value: "–" if value is None else f"{value:.4g}"
    return made.get_template("stages.html")
