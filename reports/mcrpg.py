"""The page of an iteration over the stages: parameters and metrics by iteration and stage, convergence, ledger.

Safe in the same way as the run report: data reaches the page through Jinja's escaping or as escaped JSON.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from reports.figures import BLUE, GREEN, ORANGE, PURPLE, VERMILION, Figure, numbers, plain
from reports.frame import frame
from reports.templating import environment
from reports.verdicts import pretty_unit
from reports.whole_file import write_page

FONT = "system-ui, sans-serif"
COLOURS = (BLUE, ORANGE, GREEN, VERMILION, PURPLE)
FORBIDDEN = 1e6  # scores from here on break what must hold: no place on an axis


def write_mcrpg_report(path: str | Path, page: Mapping[str, Any]) -> None:
    """Write the page; same input, same bytes.

    `page` holds title, headline, count, reached, paper (whether its columns are shown), structure, lacked [{number,
    verdict, effects, refusal, taken, before, after}], numbers (of the iterations), parameters [{group, name, unit,
    cells, paper}], metrics [{name, unit, cells (iterations x 3), paper}], bounds [{what, where, first, value,
    half_width, worst, bound, holds, paper, undecided}], course [{number, chi2, position [m], position_bound [m],
    performance, likeness}], tuned [{number, what, course [[simulations, score]]}], sensitivity {knobs, metrics, values,
    number} or None, ledger [{number, accepted, changes, suspicions, effects}].

    Raises OSError if the file cannot be written.
    """
    write_page(path, render_mcrpg_report(page))


def render_mcrpg_report(page: Mapping[str, Any]) -> str:
    """The page as text; arguments as in `write_mcrpg_report`."""
    figures: dict[str, Figure] = {"twin": twin_figure(page["course"]), "likeness": likeness_figure(page["course"])}
    for what in ("S", "P"):
        courses = [t for t in page["tuned"] if t["what"] == what]
        if courses:
            figures[f"tuned{what}"] = tuned_figure(courses, what)
    if page["sensitivity"] is not None:
        figures["sensitivity"] = sensitivity_figure(page["sensitivity"])
    text: str = _template().render(
        page=page,
        figures=figures,
        **frame(figures, ["compare.js"], ["run.css", "compare.css", "diagnosis.css", "mcrpg.css"]),
    )
    return text


def twin_figure(course: Sequence[Mapping[str, Any]]) -> Figure:
    """How far the twin is from the car on held-out drives, iteration by iteration: chi^2/N above, position after 2 s
    below, each with what is to be reached as a dotted line."""
    at = [entry["number"] for entry in course]
    wanted = (("y", 1.0, "sensor noise"), ("y2", course[-1]["position_bound"], "bound"))
    goals = [(axis, value, text) for axis, value, text in wanted if value]
    layout = _layout("iteration")
    return {
        "data": [
            _line(at, [e["chi2"] for e in course], "chi²/N", BLUE, "y"),
            _line(at, [e["position"] for e in course], "position after 2 s", ORANGE, "y2"),
        ],
        "layout": {
            **layout,
            "showlegend": False,
            "margin": {**layout["margin"], "b": 50},
            "xaxis": {**layout["xaxis"], "anchor": "y2"},
            "yaxis": {**_log("chi²/N"), "domain": [0.56, 1.0]},
            "yaxis2": {**_log("position after 2 s [m]"), "domain": [0.0, 0.44]},
            "shapes": [
                {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "yref": axis, "y0": value, "y1": value,
                 "line": {"color": GREEN, "width": 1.6, "dash": "dot"}}
                for axis, value, _ in goals
            ],
            "annotations": [
                {"xref": "paper", "x": 1, "xanchor": "right", "yref": axis, "y": math.log10(value), "yanchor": "bottom",
                 "text": text, "showarrow": False, "font": {"color": GREEN}}
                for axis, value, text in goals
            ],
        },
    }  # fmt: skip


def likeness_figure(course: Sequence[Mapping[str, Any]]) -> Figure:
    """What is missing of an MNCC of 1 between DT and RW, on a log axis, and the performance of the stack on the car."""
    at = [entry["number"] for entry in course]
    data = [
        _line(at, [_short_of_one(e["likeness"].get(name)) for e in course], f"1 - MNCC {plain(name)}", colour, "y")
        for name, colour in zip(course[0]["likeness"], COLOURS, strict=False)
    ]
    return {
        "data": data,
        "layout": {**_layout("iteration"), "yaxis": _log("1 - MNCC, DT to RW")},
    }


def tuned_figure(courses: Sequence[Mapping[str, Any]], what: str) -> Figure:
    """Best score so far over the simulations, a line an iteration."""
    data = []
    for one, colour in zip(courses, COLOURS * (1 + len(courses) // len(COLOURS)), strict=False):
        best, x, y = float("inf"), [], []
        for simulations, score in one["course"]:
            best = min(best, score)
            x.append(simulations)
            y.append(best if best < FORBIDDEN else None)
        trace = _line(x, y, f"iteration {one['number']}", colour, "y")
        data.append({**trace, "mode": "lines", "line": {**trace["line"], "shape": "hv"}})
    unit = "replays of logs" if what == "S" else "simulations"
    return {"data": data, "layout": {**_layout(unit), "yaxis": {"title": {"text": "best score"}, "zeroline": False}}}


def sensitivity_figure(found: Mapping[str, Any]) -> Figure:
    """Heat map: how far a metric moves, in units of its scale, when a knob goes through its range."""
    names = [plain(k) for k in found["knobs"]]
    values = [[None if v is None else round(v, 4) for v in row] for row in found["values"]]
    text = [["" if v is None else f"{v:.2g}" for v in row] for row in values]
    return {
        "data": [{
            "type": "heatmap", "x": [plain(m) for m in found["metrics"]], "y": names, "z": values, "text": text,
            "texttemplate": "%{text}", "colorscale": [[0, "rgba(0,114,178,0.04)"], [1, BLUE]], "showscale": False,
            "zmin": 0, "xgap": 2, "ygap": 2, "hovertemplate": "%{y} moves %{x} by %{z:.3g} of its scale<extra></extra>",
        }],
        "layout": {
            "height": 120 + 28 * len(names), "margin": {"l": 190, "r": 14, "t": 10, "b": 70},
            "font": {"size": 12.5, "family": FONT}, "showlegend": False,
            "yaxis": {"autorange": "reversed", "showgrid": False, "fixedrange": True},
            "xaxis": {"showgrid": False, "fixedrange": True},
        },
    }  # fmt: skip


def _short_of_one(mncc: float | None) -> float | None:
    return None if mncc is None else max(1.0 - mncc, 1e-7)


def _line(
    x: Sequence[float], y: Sequence[float | None], name: str, colour: str, axis: str, dash: str = "solid"
) -> Figure:
    values = numbers([float("nan") if v is None else v for v in y], 7)
    return {
        "type": "scatter", "mode": "lines+markers", "name": name, "x": list(x), "y": values, "yaxis": axis,
        "line": {"color": colour, "width": 2.2, "dash": dash}, "marker": {"color": colour, "size": 8},
    }  # fmt: skip


def _log(title: str) -> Figure:
    """A logarithmic axis that names the powers of ten alone."""
    return {"type": "log", "title": {"text": title}, "zeroline": False, "dtick": 1, "exponentformat": "power"}


def _layout(x: str) -> Figure:
    axis: Figure = {"title": {"text": x}, "zeroline": False}
    if x == "iteration":
        axis["dtick"] = 1
    return {
        "height": 320, "margin": {"l": 70, "r": 70, "t": 10, "b": 84}, "font": {"size": 12.5, "family": FONT},
        "showlegend": True, "legend": {"orientation": "h", "x": 0, "y": 0.0, "yref": "container", "yanchor": "bottom"},
        "xaxis": axis,
    }  # fmt: skip


@cache
def _template() -> Any:
    made = environment()
    made.filters["unit"] = pretty_unit
    made.filters["number"] = _number
    return made.get_template("mcrpg.html")


def _number(value: float | None) -> str:
    if value is None:
        return "–"
    if abs(value) < 1e-12:
        return "0"  # what rounding left of a difference
    return f"{value:.5f}" if 0.9 < abs(value) < 1.0 else f"{value:.3g}"
