"""The page of a comparison: how far a model is from measured logs, where, and what it looks like.

Safe in the same way as the run report: data reaches the page through Jinja's escaping or as escaped JSON.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.figures import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, YELLOW, Figure, numbers, plain, sampled, thin
from reports.frame import frame
from reports.templating import environment
from reports.verdicts import pretty_unit
from reports.whole_file import write_page

BAND = 2.0  # sigma of the noise band around the model
CURVE_POINTS = 2400  # drawn of a signal; chosen, not measured: more than a screen has columns
PATH_POINTS = 2500  # drawn of a path; chosen, not measured
REGIME_COLOURS = {
    "standstill": "#B8BEC6", "launch": GREEN, "cruise": SKY, "lift_off": YELLOW, "braking": VERMILION,
    "reverse": PURPLE, "turn_in": ORANGE, "steady_turn": BLUE,
}  # fmt: skip
LABELS = {
    "v": "speed", "yaw_rate": "yaw rate", "ax": "acceleration<br>along", "ay": "acceleration<br>across",
    "steer": "road-wheel<br>angle", "yaw": "heading<br>error", "along": "position error<br>along",
    "across": "position error<br>across", "x": "x error", "y": "y error",
}  # fmt: skip
OVERLAID = ("v", "yaw_rate", "ax", "ay", "steer")  # measured over model; of the rest the difference is drawn
# From "within noise" to "far off": dark blue would hide in dark mode, so grey through yellow to red
SCALE = [[0.0, "#9AA7B4"], [0.3, "#E9D35B"], [0.6, "#E69F00"], [1.0, "#C4314B"]]
SCALE_TOP = 20.0  # times the noise at the end of the scale, at least
TICKS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0)


def write_compare_report(path: str | Path, pages: Sequence[Mapping[str, Any]]) -> None:
    """Write one page for one or more logs compared with a model; same input, same bytes.

    Each of `pages` is a mapping with log, model, headline, alignment {lag [s], coverage}, signals {name: {rmse, nrmse,
    chi2_per_n, mncc, lag, gain, iso18571, unit, noise}}, where [{channel, regime, share_of_error, share_of_time,
    kind}], skipped, t (n,) [s], measured, modelled, residuals {name: (n,)}, ribbons {row: [(regime, from, to)]},
    not_judged (why stretches are not judged, or ""), unjudged [(from, to)] [s], mapping [{name, field, unit, change}],
    groups {group: {channel: RMS error / noise or None}}, segments [s], position ((n,), (n,)) [m] or None, error (n,)
    [times the noise].

    Raises OSError if the file cannot be written.
    """
    write_page(path, render_compare_report(pages))


def render_compare_report(pages: Sequence[Mapping[str, Any]]) -> str:
    """The page as text; arguments as in `write_compare_report`."""
    figures: dict[str, Figure] = {}
    for number, page in enumerate(pages):
        figures[f"groups{number}"] = groups_figure(page["groups"], page["signals"])
        if page["position"] is not None:
            x, y = page["position"]
            figures[f"path{number}"] = path_figure(page["t"], x, y, page["error"])
        figures[f"time{number}"] = time_figure(page)
    text: str = _template().render(
        pages=pages,
        figures=figures,
        regimes=REGIME_COLOURS,
        **frame(figures, ["compare.js"], ["run.css", "compare.css"]),
    )
    return text


def groups_figure(groups: Mapping[str, Mapping[str, float | None]], signals: Mapping[str, Any]) -> Figure:
    """Error in units of the noise, channel by regime and speed: one look says where."""
    names = list(groups)
    channels = sorted(signals, key=lambda name: -_number(signals[name].get("chi2_per_n")))
    values = [[groups[group].get(channel) for group in names] for channel in channels]
    top = _top([v for row in values for v in row if v is not None])
    shade = [[None if v is None else math.log10(max(v, 1.0)) for v in row] for row in values]
    text = [["" if v is None else _short(v) for v in row] for row in values]
    return {
        "data": [{
            "type": "heatmap", "x": [plain(n.replace("_", " ").replace("speed ", "")) for n in names],
            "y": channels, "z": shade, "text": text, "texttemplate": "%{text}", "zmin": 0.0,
            "zmax": math.log10(top), "colorscale": SCALE, "showscale": False, "xgap": 2, "ygap": 2,
            "textfont": {"color": "#16191d", "size": 12}, "hoverongaps": False,
            "hovertemplate": "%{y} in %{x}: %{text} times the noise<extra></extra>",
        }],
        "layout": {
            "height": 96 + 30 * len(channels), "margin": {"l": 68, "r": 54, "t": 68, "b": 8},
            "font": {"size": 12, "family": "system-ui, sans-serif"},
            "xaxis": {"side": "top", "tickangle": -38, "fixedrange": True, "showgrid": False},
            "yaxis": {"autorange": "reversed", "fixedrange": True, "showgrid": False},
        },
    }  # fmt: skip


def path_figure(t: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64],
                error: NDArray[np.float64]) -> Figure:  # fmt: skip
    """The driven path from above, coloured by the error, worst parts on top.

    All (n,): t [s], x and y [m], and the error in multiples of the noise.
    """
    known = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    known = known[:: max(1, len(known) // PATH_POINTS)]
    _, line_x = sampled(t[known], x[known])
    _, line_y = sampled(t[known], y[known])
    judged = known[np.isfinite(error[known])]
    left_out = known[~np.isfinite(error[known])]
    level = error[judged]
    order = np.argsort(level, kind="stable")
    rows = judged[order]
    top = _top(level)
    ticks = [v for v in TICKS if v < 0.8 * top] + [top]
    labels = ["noise", *(f"{v:.3g}×" for v in ticks[1:-1]), f"{top:.0f}×+"]
    traces: list[Figure] = [
        {"type": "scatter", "mode": "lines", "x": numbers(line_x, 2), "y": numbers(line_y, 2), "hoverinfo": "skip",
         "line": {"color": "#9AA7B4", "width": 1.5}, "showlegend": False},
        {"type": "scatter", "mode": "markers", "x": numbers(x[rows], 2), "y": numbers(y[rows], 2),
         "marker": {"color": numbers(np.log10(np.clip(level[order], 1.0, top)), 3), "cmin": 0.0,
                    "cmax": math.log10(top), "colorscale": SCALE, "size": 6,
                    "colorbar": {"tickvals": [math.log10(v) for v in ticks],
                                 "ticktext": labels, "thickness": 10, "len": 0.9,
                                 "outlinewidth": 0}},
         "text": [f"t = {t[row]:.1f} s: {_short(float(error[row]))} times the noise" for row in rows],
         "hoverinfo": "text", "showlegend": False},
    ]  # fmt: skip
    if len(left_out):
        traces.insert(1, {
            "type": "scatter", "mode": "markers", "x": numbers(x[left_out], 2), "y": numbers(y[left_out], 2),
            "marker": {"symbol": "x-thin", "size": 5, "line": {"color": "#9AA7B4", "width": 1}},
            "text": [f"t = {t[row]:.1f} s: not judged" for row in left_out], "hoverinfo": "text",
            "name": "not judged", "showlegend": True,
        })  # fmt: skip
    if len(known):
        traces.append({"type": "scatter", "mode": "markers+text", "x": numbers(x[known[:1]], 2), "hoverinfo": "skip",
                       "y": numbers(y[known[:1]], 2), "text": ["start"], "textposition": "top right",
                       "marker": {"symbol": "diamond", "size": 11, "color": BLUE}, "showlegend": False})  # fmt: skip
    return {
        "data": traces,
        "layout": {
            "height": 420, "margin": {"l": 56, "r": 0, "t": 8, "b": 40}, "hovermode": "closest", "dragmode": "pan",
            "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom"},
            "font": {"size": 11.5, "family": "system-ui, sans-serif"},
            "xaxis": {"title": {"text": "x [m]"}, "zeroline": False},
            "yaxis": {"title": {"text": "y [m]"}, "scaleanchor": "x", "zeroline": False},
        },
    }  # fmt: skip


def time_figure(page: Mapping[str, Any]) -> Figure:
    """Regimes, then a row a channel: measured, model, noise band; the difference where the curves would hide it."""
    t, signals = page["t"], page["signals"]
    worst = sorted(signals, key=lambda name: -_number(signals[name].get("chi2_per_n")))
    rows = [name for name in worst if name in OVERLAID]
    rest = page["residuals"]
    position = "along" in rest
    for name in worst:
        if name in ("x", "y") and position:
            continue
        if name not in OVERLAID:
            rows.append(name)
    if position:
        rows += ["along", "across"]
    traces = _ribbons(page["ribbons"], t)
    for k, name in enumerate(rows):
        axis = f"y{k + 2}"
        key = "x" if name in ("along", "across") else name
        sigma, unit = float(signals[key]["noise"]), pretty_unit(signals[key]["unit"])
        if name in OVERLAID:
            gap = np.where(np.isfinite(page["modelled"][name]), page["measured"][name], np.nan)
            traces += _band(t, page["modelled"][name], sigma, axis, k == 0)
            traces.append(_line(t, gap, "measured", axis, BLUE, 1.1, unit, k == 0))
            traces.append(_line(t, page["modelled"][name], "model", axis, ORANGE, 1.5, unit, k == 0))
        else:
            traces += _band(t, np.where(np.isfinite(rest[name]), 0.0, np.nan), sigma, axis, False)
            traces.append(_line(t, rest[name], "measured - model", axis, GREEN, 1.1, unit, k == len(rows) - 1))
    return {"data": traces, "layout": _layout(page, rows)}


def _ribbons(ribbons: Mapping[str, Sequence[tuple[str, float, float]]], t: NDArray[np.float64]) -> list[Figure]:
    found: list[Figure] = []
    names = {"along": "along", "turns": "turning"}
    scale = 1000.0 / max(float(t[-1] - t[0]), 1e-3)
    for row, runs in ribbons.items():
        if not runs:
            continue
        found.append({
            "type": "bar", "orientation": "h", "xaxis": "x", "yaxis": "y", "showlegend": False, "width": 0.8,
            "y": [names.get(row, row)] * len(runs), "base": numbers([a for _, a, _ in runs], 3),
            "x": numbers([b - a for _, a, b in runs], 3),
            "text": [n.replace("_", " ") if (b - a) * scale > 6.6 * len(n) + 6 else "" for n, a, b in runs],
            "textposition": "inside", "insidetextanchor": "start", "textangle": 0, "constraintext": "none",
            "insidetextfont": {"color": "#111111", "size": 10.5},
            "marker": {"color": [REGIME_COLOURS.get(n, SKY) for n, *_ in runs], "opacity": 0.8},
            "hovertext": [f"{n.replace('_', ' ')}, {a:.1f} to {b:.1f} s" for n, a, b in runs], "hoverinfo": "text",
        })  # fmt: skip
    return found


def _band(t: NDArray[np.float64], middle: NDArray[np.float64], sigma: float, axis: str, legend: bool) -> list[Figure]:
    """Filled band of +- BAND sigma around a curve, a polygon a stretch without gaps."""
    at, y = thin(*sampled(t, middle), CURVE_POINTS // 2)
    known = np.isfinite(y)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], known.astype(np.int8), [0]]))).reshape(-1, 2)
    xs: list[float | None] = []
    ys: list[float | None] = []
    for first, end in edges:
        xs += [*numbers(at[first:end], 3), *numbers(at[first:end][::-1], 3), None]
        ys += [*numbers(y[first:end] + BAND * sigma, 5), *numbers(y[first:end][::-1] - BAND * sigma, 5), None]
    return [{
        "type": "scatter", "mode": "lines", "x": xs, "y": ys, "fill": "toself", "fillcolor": "rgba(230,159,0,0.25)",
        "line": {"width": 0}, "xaxis": "x", "yaxis": axis, "hoverinfo": "skip",
        "name": f"noise, ±{BAND:g}σ", "legendgroup": "band", "showlegend": legend,
    }]  # fmt: skip


def _line(t: NDArray[np.float64], y: NDArray[np.float64], name: str, axis: str, colour: str, width: float, unit: str,
          legend: bool) -> Figure:  # fmt: skip
    at, value = thin(*sampled(t, y), CURVE_POINTS)
    return {
        "type": "scatter", "mode": "lines", "name": name, "x": numbers(at, 3), "y": numbers(value, 5), "xaxis": "x",
        "yaxis": axis, "line": {"color": colour, "width": width}, "connectgaps": False, "showlegend": legend,
        "legendgroup": name, "hovertemplate": f"{name} %{{y:.4g}} {unit}<extra></extra>",
    }  # fmt: skip


def _layout(page: Mapping[str, Any], rows: Sequence[str]) -> Figure:
    t = page["t"]
    ribbon, height, gap = 48.0, 112.0, 14.0
    total = ribbon + len(rows) * (height + gap)
    layout: Figure = {
        "height": round(total + 84), "margin": {"l": 92, "r": 10, "t": 34, "b": 44}, "barmode": "overlay",
        "hovermode": "x", "showlegend": True, "dragmode": "zoom",
        "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom"},
        "font": {"size": 11.5, "family": "system-ui, sans-serif"},
        "xaxis": {"title": {"text": "time [s]"}, "range": [float(t[0]), float(t[-1])], "zeroline": False,
                  "anchor": "free", "position": 0},
        "yaxis": {"domain": [1.0 - ribbon / total, 1.0], "type": "category", "fixedrange": True, "showgrid": False,
                  "categoryorder": "array", "categoryarray": ["turning", "along"], "range": [-0.5, 1.5]},
    }  # fmt: skip
    layout["shapes"] = [
        {"type": "rect", "xref": "x", "yref": "paper", "x0": a, "x1": b, "y0": 0, "y1": 1, "layer": "below",
         "fillcolor": "rgba(139,149,161,0.22)", "line": {"width": 0}}
        for a, b in page.get("unjudged", ())
    ]  # fmt: skip
    top = total - ribbon - gap
    for k, name in enumerate(rows):
        key = "x" if name in ("along", "across") else name
        unit = pretty_unit(page["signals"][key]["unit"])
        low, high = max(top - height, 0.0) / total, top / total
        layout[f"yaxis{k + 2}"] = {
            "domain": [low, high], "title": {"text": f"{LABELS.get(name, plain(name))}<br>[{unit}]", "standoff": 6},
            "fixedrange": True, "zeroline": True, "anchor": "x", "nticks": 5,
        }  # fmt: skip
        top -= height + gap
    return layout


def _top(errors: Sequence[float] | NDArray[np.float64]) -> float:
    """End of the colour scale: what nearly all of the errors stay below, so that a bad model still shows its worst."""
    return max(SCALE_TOP, float(np.quantile(np.asarray(errors), 0.97))) if len(errors) else SCALE_TOP


def _number(value: Any) -> float:
    return float(value) if isinstance(value, (int, float)) and math.isfinite(value) else 0.0


def _short(value: float) -> str:
    if not math.isfinite(value):
        return "-"
    return f"{value:.1f}" if value < 9.95 else f"{value:.0f}"


@cache
def _template() -> Any:
    made = environment()
    made.filters["unit"] = pretty_unit
    made.filters["short"] = lambda value: "–" if value is None else f"{value:.3g}"
    made.filters["fixed"] = lambda value, digits: "–" if value is None else f"{value:.{digits}f}"
    made.filters["signed"] = lambda value: "–" if value is None else f"{round(value, 3) + 0.0:+.3f}"
    made.filters["percent"] = lambda value: "–" if value is None else f"{100.0 * value:.0f} %"
    made.filters["level"] = _level
    return made.get_template("compare.html")


def _level(chi2: Any) -> str:
    """Class of a chi^2/N: within the noise, visible, far off."""
    value = _number(chi2)
    return "good" if value <= 1.3 else "doubt" if value <= 10.0 else "bad"
