"""The page of a diagnosis: which effect a model lacks, how much of the error it explains, and what it looks like.

Safe in the same way as the run report: data reaches the page through Jinja's escaping or as escaped JSON.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.compare import LABELS
from reports.figures import BLUE, ORANGE, VERMILION, Figure, numbers, plain, sampled, thin
from reports.frame import frame
from reports.templating import environment
from reports.verdicts import pretty_unit
from reports.whole_file import write_page

BAND = 2.0  # sigma of the noise band
CURVE_POINTS = 2000  # drawn of a signal; chosen, not measured: about the columns of a screen
NOISE = 1.3  # chi^2/N up to which only noise is left
GREY = "#8B95A1"  # what was measured, and what is no finding
BADGES = {
    "NOTHING_MISSING": "nothing missing", "NAMED": "named", "AMBIGUOUS": "ambiguous", "PARTIAL": "partly named",
    "UNKNOWN": "unknown", "NOT_EXCITED": "not excited",
}  # fmt: skip
FONT = "system-ui, sans-serif"


def write_diagnosis_report(path: str | Path, page: Mapping[str, Any]) -> None:
    """Write the page of one diagnosis; same input, same bytes.

    `page` holds verdict, mapping [{name, field, unit, change}] (may be left out), headline, model, logs, held_out,
    changed (something was found), noise (what an error of 1 is, in words), effects [{name, action,
    standing, apart (judged on detections), physics, equation, parameters [{key, value, interval, unit, meaning}], fit
    and held_out {value, low, high, shown} or None (share of the error), rivals [{name, physics}], manoeuvre, reveals}],
    vetoed, remarks [lines], second_opinion, fitted_along, ladder [{label, fit, held_out} chi^2/N], null_line (chi^2/N
    that chance alone would reach), tiles (signals that tell most), signals [{name, unit, noise, before, after,
    held_before, held_after, chi2_before, chi2_after} RMSE], not_excited [{name, physics, reveals}],
    left [(aspect, words)], command, trial (adds what is provisional as well), plan,
    close {log, held_out, channel, unit, error, t, noise, measured, before, after} or None, over_time
    [{log, held_out, t, rows {name: {before, after, noise}}, units, quiet}].

    Raises OSError if the file cannot be written.
    """
    write_page(path, render_diagnosis_report(page))


def render_diagnosis_report(page: Mapping[str, Any]) -> str:
    """The page as text; arguments as in `write_diagnosis_report`."""
    changed = bool(page["changed"])
    new = with_effects(page["effects"]) if changed else ""
    given = BLUE if page["verdict"] in ("NOTHING_MISSING", "NOT_EXCITED") else VERMILION
    steps = page["ladder"] if changed else [{"label": s["name"], "fit": s["chi2_before"], "held_out": None}
                                            for s in page["signals"]]  # fmt: skip
    figures: dict[str, Figure] = {"ladder": ladder_figure(steps, page["null_line"], steps=changed, noise=page["noise"])}
    if page["close"] is not None:
        figures["close"] = close_figure(page["close"], new=new, given=given)
    for number, one in enumerate(page["over_time"]):
        if one["rows"]:
            figures[f"time{number}"] = residual_figure(one, new=new, given=given)
    text: str = _template().render(
        page=page,
        figures=figures,
        badge=BADGES[page["verdict"]],
        new=new,
        **frame(figures, ["compare.js"], ["run.css", "compare.css", "diagnosis.css"]),
    )
    return text


def with_effects(effects: Sequence[Mapping[str, Any]]) -> str:
    """ "with steer_delay", "with 3 changes": what the better model is called."""
    if len(effects) > 1:
        return f"with {len(effects)} changes"
    return f"with{'out' if effects[0]['action'] == 'remove' else ''} {plain(effects[0]['name'])}"


def ladder_figure(rungs: Sequence[Mapping[str, Any]], null_line: float | None, *, steps: bool = True,
                  noise: str = "sensor noise") -> Figure:  # fmt: skip
    """Error of each step, from the model as given downwards, on a log axis; green where only noise is left.

    Not `steps`: the rungs stand for themselves, as signals do. noise: what an error of 1 is.
    """
    rows = [f"{plain(s['label'])} " for s in rungs]
    values = [s["fit"] for s in rungs] + [s["held_out"] for s in rungs if s["held_out"] is not None]
    values += [null_line] if null_line else []
    # Of a log without noise what is left may be far below 1
    low, high = max(min(0.7, 0.7 * min(values)), 0.01), max(2.2, 1.6 * max(values))
    traces: list[Figure] = []
    shapes: list[Figure] = [
        {"type": "rect", "xref": "x", "yref": "paper", "x0": low, "x1": NOISE, "y0": 0, "y1": 1, "layer": "below",
         "fillcolor": "rgba(0,158,115,0.20)", "line": {"width": 0}},
    ]  # fmt: skip
    notes: list[Figure] = [
        {"xref": "x", "yref": "paper", "x": math.log10(low), "y": 1.0, "xanchor": "left", "yanchor": "bottom",
         "text": f"about {noise}", "showarrow": False, "font": {"size": 11.5, "color": "#009E73"}},
    ]  # fmt: skip
    if null_line:
        shapes.append({"type": "line", "xref": "x", "yref": "paper", "x0": null_line, "x1": null_line, "y0": 0,
                       "y1": 1, "line": {"color": GREY, "width": 1.5, "dash": "dash"}})  # fmt: skip
        traces.append({"type": "scatter", "mode": "lines", "name": "reached by chance alone", "x": [None], "y": [None],
                       "line": {"color": GREY, "width": 1.5, "dash": "dash"}, "hoverinfo": "skip"})  # fmt: skip
    for key, name, colour, symbol, dash in (
        ("fit", "fitted on", BLUE, "circle", "solid"),
        ("held_out", "held out", ORANGE, "diamond-open", "dot"),
    ):
        known = [(row, s[key], s["fit"]) for row, s in zip(rows, rungs, strict=True) if s[key] is not None]
        told = [key == "fit" or abs(math.log(v / fit)) > 0.05 for _, v, fit in known]
        # Lines fall from the upper right to the lower left: the other two corners of a marker are free
        sides = ["bottom right" if (v > fit if key == "held_out" else _other(s, v) < v) else "top left"
                 for (_, v, fit), s in zip(known, [s for s in rungs if s[key] is not None], strict=True)]  # fmt: skip
        if known:
            traces.append({
                "type": "scatter", "mode": f"{'lines+' if steps else ''}markers+text", "name": name,
                "y": [row for row, *_ in known], "x": numbers([v for _, v, _ in known], 4), "textposition": sides,
                "text": [_short(v) if tell else "" for (_, v, _), tell in zip(known, told, strict=True)],
                "textfont": {"size": 12, "color": colour}, "cliponaxis": False,
                "line": {"color": colour, "width": 2, "dash": dash},
                "marker": {"color": colour, "size": 10, "symbol": symbol, "line": {"width": 2, "color": colour}},
                "hovertemplate": f"%{{y}}: chi²/N %{{x:.3g}}, {name}<extra></extra>",
            })  # fmt: skip
    ticks = [
        v
        for v in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000)
        if low <= v <= high
    ]
    return {
        "data": traces,
        "layout": {
            "height": max(340, 140 + (54 if steps else 32) * len(rows)) + (36 if steps else 0),
            # a letter is up to 7.4 px wide; a narrow legend has three rows
            "margin": {"l": max(168, round(7.4 * max(map(len, rows)))), "r": 24, "t": 40, "b": 120 if steps else 84},
            "font": {"size": 12.5, "family": FONT}, "shapes": shapes, "annotations": notes, "showlegend": steps,
            "legend": {"orientation": "h", "x": 0, "y": 0.0, "yref": "container", "yanchor": "bottom"},
            "xaxis": {"type": "log", "range": [math.log10(low), math.log10(high)], "tickvals": ticks,
                      "ticktext": [str(v) for v in ticks], "zeroline": False, "fixedrange": True,
                      "title": {"text": f"error, chi²/N (1 = {noise})", "standoff": 6}},
            "yaxis": {"type": "category", "categoryorder": "array", "categoryarray": rows[::-1], "fixedrange": True,
                      "range": [-0.55, len(rows) - 0.45], "tickfont": {"size": 13}},
        },
    }  # fmt: skip


def _other(rung: Mapping[str, Any], value: float) -> float:
    """The held-out error of a rung, or `value` itself if there is none."""
    return value if rung["held_out"] is None else float(rung["held_out"])


def close_figure(close: Mapping[str, Any], *, new: str = "", given: str = VERMILION) -> Figure:
    """A few seconds of one signal: measured with its noise, the model as given, and the `new` one ("": none)."""
    t, unit = close["t"], pretty_unit(close["unit"])
    traces = [
        _band(t, close["measured"], close["noise"], "y", "noise ±2σ"),
        _line(t, close["measured"], "measured", "y", _Pen(GREY, 6.0), unit),
        _line(t, close["before"], "model as given", "y", _Pen(given, 2.4, "dash" if new else "solid"), unit),
    ]
    if new:
        traces.append(_line(t, close["after"], new, "y", _Pen(BLUE, 2.4), unit))
    label = plain(_spoken(close["channel"])) + (" error (model - measured)" if close["error"] else "")
    return {
        "data": traces,
        "layout": {
            "height": 340, "margin": {"l": 70, "r": 14, "t": 40, "b": 44}, "hovermode": "x", "showlegend": True,
            "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom"},
            "font": {"size": 12.5, "family": FONT},
            "xaxis": {"title": {"text": "time [s]"}, "range": [float(t[0]), float(t[-1])], "zeroline": False},
            "yaxis": {"title": {"text": f"{label} [{unit}]", "standoff": 8}, "zeroline": False, "nticks": 7},
        },
    }  # fmt: skip


def residual_figure(one: Mapping[str, Any], *, new: str = "", given: str = VERMILION) -> Figure:
    """Measured - model over time, a row a signal, before and after on the same axes, in the band of the noise."""
    t = one["t"]
    traces: list[Figure] = []
    names = list(one["rows"])
    for k, name in enumerate(names):
        row, axis = one["rows"][name], "y" if k == 0 else f"y{k + 1}"
        unit = pretty_unit(one["units"][name])
        before = _line(t, row["before"], "model as given", axis, _Pen(given, 1.3), unit, legend=k == 0)
        traces.append(before)
        if new:
            traces.append(_line(t, row["after"], new, axis, _Pen(BLUE, 1.3), unit, legend=k == 0))
        for side in (-BAND, BAND):
            edge = np.full(2, side * row["noise"])
            line = _line(np.array([t[0], t[-1]]), edge, "noise, ±2σ", axis, _Pen("#009E73", 1.4, "dot"), unit,
                         legend=k == 0 and side > 0)  # fmt: skip
            traces.append(line | {"hoverinfo": "skip", "hovertemplate": None})
    return {"data": traces, "layout": _rows_layout(one, names)}


def _rows_layout(one: Mapping[str, Any], names: Sequence[str]) -> Figure:
    height, gap, t = 104.0, 14.0, one["t"]
    total = len(names) * (height + gap) - gap
    layout: Figure = {
        "height": round(total + 84), "margin": {"l": 96, "r": 12, "t": 36, "b": 46}, "hovermode": "x",
        "showlegend": True, "dragmode": "zoom", "font": {"size": 11.5, "family": FONT},
        "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "font": {"size": 12.5}},
        "xaxis": {"title": {"text": "time [s]"}, "range": [float(t[0]), float(t[-1])], "zeroline": False,
                  "anchor": "free", "position": 0},
    }  # fmt: skip
    top = total
    for k, name in enumerate(names):
        low, high = max(top - height, 0.0) / total, top / total
        title = f"{LABELS.get(name, plain(name))}<br>[{pretty_unit(one['units'][name])}]"
        layout["yaxis" if k == 0 else f"yaxis{k + 1}"] = {
            "domain": [low, high], "title": {"text": title, "standoff": 6}, "fixedrange": True, "zeroline": True,
            "anchor": "x", "nticks": 5,
        }  # fmt: skip
        top -= height + gap
    return layout


@dataclass(frozen=True)
class _Pen:
    """How a line is drawn; width [px]."""

    colour: str
    width: float
    dash: str = "solid"


def _line(t: NDArray[np.float64], y: NDArray[np.float64], name: str, axis: str, pen: _Pen, unit: str,
          legend: bool = True) -> Figure:  # fmt: skip
    at, value = thin(*sampled(t, y), CURVE_POINTS)
    return {
        "type": "scatter", "mode": "lines", "name": name, "x": numbers(at, 3), "y": numbers(value, 5), "xaxis": "x",
        "yaxis": axis, "line": {"color": pen.colour, "width": pen.width, "dash": pen.dash}, "connectgaps": False,
        "showlegend": legend, "legendgroup": name, "hovertemplate": f"{name} %{{y:.4g}} {unit}<extra></extra>",
    }  # fmt: skip


def _band(t: NDArray[np.float64], middle: NDArray[np.float64], sigma: float, axis: str, name: str) -> Figure:
    known = np.isfinite(middle)
    at, y = t[known], middle[known]
    return {
        "type": "scatter", "mode": "lines", "fill": "toself", "fillcolor": "rgba(139,149,161,0.28)", "name": name,
        "x": [*numbers(at, 3), *numbers(at[::-1], 3)], "line": {"width": 0}, "hoverinfo": "skip", "xaxis": "x",
        "y": [*numbers(y + BAND * sigma, 5), *numbers(y[::-1] - BAND * sigma, 5)], "yaxis": axis,
    }  # fmt: skip


def _short(value: float) -> str:
    return f"{value:.2f}" if value < 9.995 else f"{value:.1f}" if value < 99.95 else f"{value:.0f}"


def _percent(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{100.0 * value:.0f} %" if abs(value) >= 0.0095 or value == 0.0 else f"{100.0 * value:.1f} %"


def _spoken(name: str) -> str:
    """A signal's name in words."""
    words = LABELS | {"ax": "acceleration", "ay": "lateral acceleration"}
    return words.get(name, name).replace("<br>", " ").removesuffix(" error")


def _level(chi2: float | None) -> str:
    """Class of a chi^2/N: within the noise, visible, far off."""
    return "" if chi2 is None else "good" if chi2 <= NOISE else "doubt" if chi2 <= 10.0 else "bad"


@cache
def _template() -> Any:
    made = environment()
    made.filters["unit"] = pretty_unit
    made.filters["short"] = lambda value: "–" if value is None else f"{value:#.3g}".rstrip(".")
    made.filters["chi2"] = lambda value: "–" if value is None else _short(value)
    made.filters["percent"] = _percent
    made.filters["spoken"] = _spoken
    made.filters["pin"] = lambda value: round(100.0 * min(max(value, 0.0), 1.0), 2)
    made.filters["level"] = _level
    return made.get_template("diagnosis.html")
