"""Figures as plain dicts in plotly's format, one function a figure; used by the run report and the workbench alike.

Nothing here imports plotly: a dict of data and layout is what its JavaScript wants. Colours are those of Okabe and Ito
(Color Universal Design, 2008), which stay apart under the common kinds of colour blindness; text and grid colours are
left to the page, which knows whether it is light or dark.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Figure = dict[str, Any]
Columns = Mapping[str, NDArray[np.float64]]

BLUE, ORANGE, GREEN, VERMILION, PURPLE, SKY, YELLOW = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#F0E442",
)  # fmt: skip
RIBBONS = (SKY, ORANGE, GREEN, PURPLE, YELLOW, VERMILION, BLUE)
MAX_POINTS = 3000  # a curve; more than the pixels of any screen it is drawn on
PLOT_WIDTH = 520.0  # px that a time axis has at least on a page of 1280 px
LETTER = 6.3  # px, width of a letter in the small labels
NET_PREFIX = "ads.net."
TTC_INVERSE_TOP = 2.0  # 1/s, a time to collision of 0.5 s: beyond it the axis of 1/TTC ends, or at twice the bound
SHOWN_EVENTS = ("story.event", "collision", "request", "goal", "stop", "timeout", "fault")


def thin(t: ArrayLike, y: ArrayLike, limit: int = MAX_POINTS) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """About `limit` points of a curve that keep its extremes, the least and greatest value of each of equal buckets,
    and the places where it pauses (NaN).

    Both (n,), in any units, which the results keep.
    """
    t, y = np.asarray(t, dtype=np.float64), np.asarray(y, dtype=np.float64)
    n = len(t)
    if n <= limit:
        return t, y
    buckets = max(limit // 2, 1)
    width = -(-n // buckets)
    starts = np.arange(0, n, width)
    padded = np.full(len(starts) * width, np.nan)
    padded[:n] = y
    rows = padded.reshape(len(starts), width)
    low = np.where(np.isnan(rows), np.inf, rows).argmin(axis=1) + starts
    high = np.where(np.isnan(rows), -np.inf, rows).argmax(axis=1) + starts
    unknown = np.isnan(y)
    pauses = np.flatnonzero(unknown[1:] & ~unknown[:-1]) + 1
    pauses = pauses if len(pauses) < limit // 4 else pauses[:0]  # samples with holes between them are no pauses
    keep = np.unique(np.concatenate([np.minimum(low, n - 1), np.minimum(high, n - 1), pauses, [0, n - 1]]))
    return t[keep], y[keep]


def sampled(t: ArrayLike, y: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A curve by its own samples, with one NaN where it pauses for more than five of its usual steps and 0.1 s.

    Both (n,), in any units, which the results keep. In a log of several rates a slow channel is NaN between its
    samples; drawn row by row it would fall into dots.
    """
    t, y = np.asarray(t, dtype=np.float64), np.asarray(y, dtype=np.float64)
    known = np.isfinite(y)
    if known.sum() < 2:
        return t, y
    at, value = t[known], y[known]
    steps = np.diff(at)
    pauses = np.flatnonzero(steps > max(0.1, 5.0 * float(np.median(steps)))) + 1
    return np.insert(at, pauses, at[pauses - 1]), np.insert(value, pauses, np.nan)


def numbers(values: ArrayLike, digits: int = 4) -> list[float | None]:
    """JSON-able numbers: rounded to `digits` decimals, not measured (NaN) and infinite as None."""
    array = np.asarray(values, dtype=np.float64)
    rounded = (np.round(array, digits) + 0.0).tolist()
    if np.isfinite(array).all():
        return list(rounded)
    return [value if math.isfinite(value) else None for value in rounded]


def curve(
    t: ArrayLike,
    y: ArrayLike,
    name: str,
    axis: str,
    *,
    colour: str = BLUE,
    dash: str = "solid",
    unit: str = "",
    legend: str = "",
) -> Figure:
    """One line over time on the y axis `axis` ("y", "y2", ...); in the legend only under a name given for it."""
    t, y = thin(t, y)
    return {
        "type": "scatter", "mode": "lines", "name": legend or name, "x": numbers(t, 3), "y": numbers(y), "xaxis": "x",
        "yaxis": axis, "line": {"color": colour, "width": 1.6, "dash": dash},
        "connectgaps": False, "showlegend": bool(legend),
        "hovertemplate": f"{name} %{{y:.3g}} {unit}<extra></extra>",
    }  # fmt: skip


def place_intervals(columns: Columns) -> list[tuple[str, str, float, float]]:
    """(net, place, from [s], to [s]) of every time that a Petri-net place was active, by net and time."""
    t = np.asarray(columns["t"], dtype=np.float64)
    found: list[tuple[str, str, float, float]] = []
    for column in sorted(name for name in columns if name.startswith(NET_PREFIX)):
        net, _, place = column.removeprefix(NET_PREFIX).partition(".")
        active = np.nan_to_num(np.asarray(columns[column], dtype=np.float64)) > 0.5
        edges = np.flatnonzero(np.diff(np.concatenate([[0], active.astype(np.int8), [0]])))
        for first, end in edges.reshape(-1, 2):
            found.append((net, place, float(t[first]), float(t[min(end, len(t) - 1)])))
    return sorted(found, key=lambda entry: (entry[0], entry[2], entry[1]))


def place_shares(columns: Columns) -> dict[tuple[str, str], float]:
    """Share of the time that each Petri-net place was active, by (net, place)."""
    found = {}
    for column in (name for name in columns if name.startswith(NET_PREFIX)):
        net, _, place = column.removeprefix(NET_PREFIX).partition(".")
        values = np.nan_to_num(np.asarray(columns[column], dtype=np.float64))
        found[net, place] = float(np.mean(values > 0.5)) if len(values) else 0.0
    return found


def _ribbon_rows(intervals: Iterable[tuple[str, str, float, float]]) -> list[tuple[str, str, str, float, float]]:
    """(row, net, place, from, to): a row a net, and further rows where places of one net are active together."""
    ends: dict[str, list[float]] = {}
    rows = []
    for net, place, start, end in intervals:
        busy = ends.setdefault(net, [])
        row = next((i for i, until in enumerate(busy) if until <= start + 1e-9), len(busy))
        busy[row : row + 1] = [end]
        rows.append((net + "\u200b" * row, net, place, start, end))
    return rows


def ribbons(columns: Columns, axis: str) -> list[Figure]:
    """Active Petri-net places as horizontal bars over time, labelled where there is room; colours repeat with the order
    of the places."""
    rows = _ribbon_rows(place_intervals(columns))
    if not rows:
        return []
    scale = _scale(columns["t"])
    colour: dict[tuple[str, str], str] = {}
    for _, net, place, _, _ in rows:
        of_net = sum(1 for known, _ in colour if known == net)
        colour.setdefault((net, place), RIBBONS[of_net % len(RIBBONS)])
    return [{
        "type": "bar", "orientation": "h", "name": "places", "xaxis": "x", "yaxis": axis, "showlegend": False,
        "y": [row for row, *_ in rows], "base": numbers([row[3] for row in rows], 3),
        "x": numbers([row[4] - row[3] for row in rows], 3), "width": 0.86,
        "text": [plain(place) if (b - a) * scale > LETTER * len(place) + 4 else "" for _, _, place, a, b in rows],
        "textposition": "inside", "insidetextanchor": "start",
        "textangle": 0, "constraintext": "none", "cliponaxis": True,
        "textfont": {"size": 10.5, "color": "#111111"}, "insidetextfont": {"color": "#111111"},
        "marker": {"color": [colour[net, place] for _, net, place, _, _ in rows], "opacity": 0.85},
        "hovertext": [plain(f"{net}: {place}, {a:.2f} to {b:.2f} s") for _, net, place, a, b in rows],
        "hoverinfo": "text",
    }]  # fmt: skip


def _scale(t: ArrayLike) -> float:
    """Least px a second of the time axis."""
    times = np.asarray(t, dtype=np.float64)
    return PLOT_WIDTH / max(float(times[-1] - times[0]), 1e-3)


def plain(text: str) -> str:
    """`text` for plotly, which reads a little HTML in labels: its angle brackets are shown, not obeyed."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def event_marks(events: Sequence[Mapping[str, Any]], t: ArrayLike, axis: str) -> tuple[list[Figure], list[Figure]]:
    """A row of diamonds with the events' names, all of them on hover, and a thin line for each through all rows."""
    shown = sorted((event for event in events if is_shown(event)), key=lambda event: float(event["t"]))
    if not shown:
        return [], []
    names, sides = _labels([float(event["t"]) for event in shown], [short_name(event) for event in shown], t)
    kinds = {"story.event": BLUE, "request": SKY, "goal": GREEN, "stop": "#888888", "collision": VERMILION}
    colours = [kinds.get(str(event["kind"]), PURPLE) for event in shown]
    times = numbers([event["t"] for event in shown], 3)
    marks = {
        "type": "scatter", "mode": "markers+text", "name": "events", "xaxis": "x", "yaxis": axis, "showlegend": False,
        "text": [plain(name) for name in names], "textfont": {"size": 10.5}, "textposition": sides,
        "x": times, "y": [0.5] * len(shown), "hoverinfo": "text", "cliponaxis": False,
        "hovertext": [plain(event_label(event)) for event in shown],
        "marker": {"symbol": "diamond", "size": 10, "color": colours},
    }  # fmt: skip
    lines: list[Figure] = [
        {"type": "line", "xref": "x", "yref": "paper", "x0": t, "x1": t, "y0": 0, "y1": 1, "layer": "below",
         "line": {"color": colour, "width": 1, "dash": "dot"}}
        for t, colour in zip(times, colours, strict=True)
    ]  # fmt: skip
    return [marks], lines


def _labels(at: Sequence[float], names: Sequence[str], t: ArrayLike) -> tuple[list[str], list[str]]:
    """Names beside marks at the ascending times `at` [s], on the side with room; empty where there is none."""
    times = np.asarray(t, dtype=np.float64)
    scale, start, end = _scale(times), float(times[0]), float(times[-1])
    left_px, right_px = 0.0, (end - start) * scale  # room that is still free, from the left
    shown: list[str] = []
    sides: list[str] = []
    for index, (time, name) in enumerate(zip(at, names, strict=True)):
        x = (time - start) * scale
        width = LETTER * len(name) + 10.0
        following = (at[index + 1] - start) * scale - 8.0 if index + 1 < len(at) else right_px + 8.0
        to_the_right = x + width <= following
        to_the_left = x - width >= left_px
        shown.append(name if to_the_right or to_the_left else "")
        sides.append("middle right" if to_the_right or not to_the_left else "middle left")
        left_px = x + (width if to_the_right else 8.0)
    return shown, sides


def is_shown(event: Mapping[str, Any]) -> bool:
    """True for what a reader looks for: storyboard events as they fire, and what befell the run; not every state."""
    if event.get("kind") == "story.event":
        return str(event.get("text", "")).endswith("runningState")
    return event.get("kind") in SHOWN_EVENTS


def short_name(event: Mapping[str, Any]) -> str:
    """Last part of a storyboard element's path; for all else the kind."""
    if event.get("kind") != "story.event":
        return str(event.get("kind", ""))
    return re.split(r"[/.:]", str(event.get("element", "")).rstrip("/.:"))[-1][:24]


def event_label(event: Mapping[str, Any]) -> str:
    """One line: time, what, and where it stands in its file."""
    parts = [f"{float(event['t']):.2f} s", str(event.get("element") or ""), str(event.get("text") or "")]
    if event.get("file"):
        parts.append(f"({event['file']}:{event.get('line')})")
    return " ".join(part for part in parts if part)


def timeline(
    columns: Columns,
    *,
    ttc_inverse: Mapping[str, Any] | None = None,
    ttc_bound: float | None = None,
    events: Sequence[Mapping[str, Any]] = (),
    more: Sequence[tuple[str, str, float, list[Figure]]] = (),
) -> Figure:
    """Events, speed, steering angle, acceleration, inverse time to collision and Petri-net places on one time axis.

    Args:
        columns: the Log's columns; `t` [s], `v` [m/s], `steer` [rad], `ax` [m/s^2], commands and `ads.*` where there.
        ttc_inverse: {"t": [s], "value": [1/s]}, the series of the metric.
        ttc_bound: the gate's bound [1/s], drawn as a line.
        events: mappings with t [s], kind, element, text, file, line.
        more: further rows above the places: y axis, title, height [px], traces.
    """
    t = columns["t"]
    traces: list[Figure] = []
    marks, shapes = event_marks(events, t, "y")
    traces += marks
    degree = 180.0 / math.pi
    told: set[str] = set()  # the legend names a kind of line where it first occurs, and only if it does
    for axis, name, label, unit, scale in (
        ("y2", "ads.target_speed", "target speed", "m/s", 1.0),
        ("y2", "v", "speed", "m/s", 1.0),
        ("y3", "steer_cmd", "steer command", "deg", degree),
        ("y3", "steer", "steer", "deg", degree),
        ("y4", "accel_cmd", "acceleration command", "m/s²", 1.0),
        ("y4", "ax", "acceleration", "m/s²", 1.0),
    ):
        if not _is_told(columns, name):
            continue
        wanted = name.startswith("ads.") or name.endswith("_cmd")
        legend, colour, dash = ("wanted by the ADS", ORANGE, "dash") if wanted else ("driven", BLUE, "solid")
        values = np.asarray(columns[name], dtype=np.float64) * scale
        new = "" if legend in told else legend
        traces.append(curve(t, values, label, axis, colour=colour, dash=dash, unit=unit, legend=new))
        told.add(legend)
    top: float | None = None
    if ttc_inverse is not None and np.any(np.asarray(ttc_inverse["value"], dtype=np.float64) > 0.0):
        traces.append(curve(ttc_inverse["t"], ttc_inverse["value"], "1 / TTC", "y5", colour=VERMILION, unit="1/s"))
        if ttc_bound is not None and math.isfinite(ttc_bound):
            shapes.append({"type": "line", "xref": "paper", "yref": "y5", "x0": 0, "x1": 1, "y0": ttc_bound,
                           "y1": ttc_bound, "line": {"color": VERMILION, "width": 1.2, "dash": "dash"}})  # fmt: skip
        top = ttc_inverse_top(ttc_inverse["value"], ttc_bound)
        if top is not None:
            traces.append(beyond_the_axis(ttc_inverse, top, events, "y5"))
    for _, _, _, drawn_there in more:
        traces += drawn_there
    bars = ribbons(columns, "y6")
    traces += bars
    rows = list(dict.fromkeys(bars[0]["y"])) if bars else []
    drawn = {str(trace["yaxis"]) for trace in traces}
    layout = _layout(float(t[0]), float(t[-1]), shapes, rows, drawn, more)
    if top is not None:
        layout["yaxis5"] |= {"range": [0.0, 1.25 * top], "rangemode": "normal"}  # room for the marks above the cap
        layout["yaxis5"]["title"]["text"] = f"1 / TTC<br>[1/s]<br>cut at {top:g}"
    return {"data": traces, "layout": layout}


def ttc_inverse_top(values: ArrayLike, bound: float | None) -> float | None:
    """Where the axis of 1/TTC [1/s] is cut; None if nothing goes beyond. A contact counts as 100 1/s: it would press
    the bound and the approach, which a reader wants to see, onto the zero line."""
    top = TTC_INVERSE_TOP
    if bound is not None and math.isfinite(bound):
        top = max(top, 2.0 * bound)
    greatest = float(np.nanmax(np.asarray(values, dtype=np.float64)))
    return top if greatest > 1.25 * top else None


def beyond_the_axis(series: Mapping[str, Any], top: float, events: Sequence[Mapping[str, Any]], axis: str) -> Figure:
    """A mark for each stretch of 1/TTC beyond its cut axis: how far it goes; a cross if there is a collision."""
    t, value = (np.asarray(series[name], dtype=np.float64) for name in ("t", "value"))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (np.nan_to_num(value) > top).astype(np.int8), [0]])))
    hits = [float(event["t"]) for event in events if event.get("kind") == "collision"]
    step = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    at, words, symbols = [], [], []
    for first, end in edges.reshape(-1, 2):
        hit = next((hit for hit in hits if t[first] - step <= hit <= t[end - 1] + step), None)
        at.append(float(t[first]) if hit is None else hit)
        symbols.append("triangle-up" if hit is None else "x")
        reached = f"up to {float(np.max(value[first:end])):.3g} 1/s"
        words.append(reached if hit is None else f"collision, {reached}")
    to_the_left = [float(t[-1]) - when < 0.3 * float(t[-1] - t[0]) for when in at]
    return {
        "type": "scatter", "mode": "markers+text", "name": "1 / TTC beyond the axis", "xaxis": "x", "yaxis": axis,
        "x": numbers(at, 3), "y": [1.12 * top] * len(at), "showlegend": False, "hoverinfo": "text", "cliponaxis": False,
        "text": words, "hovertext": [f"{when:.2f} s: {said}" for when, said in zip(at, words, strict=True)],
        "textfont": {"size": 10.5}, "textposition": [f"middle {'left' if left else 'right'}" for left in to_the_left],
        "marker": {"symbol": symbols, "size": 9, "color": VERMILION},
    }  # fmt: skip


def _is_told(columns: Columns, name: str) -> bool:
    """True for a column with something in it; a stack that drives by its pedals leaves the acceleration at 0."""
    if name not in columns or not np.isfinite(columns[name]).any():
        return False
    pedals = [columns[pedal] for pedal in ("throttle_cmd", "brake_cmd") if pedal in columns]
    by_pedals = any(bool(np.any(np.nan_to_num(pedal))) for pedal in pedals)
    return name != "accel_cmd" or not by_pedals or bool(np.any(np.nan_to_num(columns[name])))


def _layout(
    start: float,
    end: float,
    shapes: list[Figure],
    rows: list[str],
    drawn: Collection[str],
    more: Sequence[tuple[str, str, float, list[Figure]]],
) -> Figure:
    """Rows from top to bottom; those on whose axis nothing is drawn get no room."""
    wishes = {
        "y": ("", 22.0),
        "y2": ("speed<br>[m/s]", 96.0),
        "y3": ("steer<br>[deg]", 96.0),
        "y4": ("acceleration<br>[m/s²]", 96.0),
        "y5": ("1 / TTC<br>[1/s]", 80.0),
        **{name: (title, height) for name, title, height, _ in more},
        "y6": ("", 22.0 * len(rows)),
    }
    heights = {name: height if name in drawn else 0.0 for name, (_, height) in wishes.items()}
    gap = 16.0
    total = max(sum(heights.values()) + gap * sum(1 for name, height in heights.items() if height and name != "y"), gap)
    layout: Figure = {
        "height": round(total + 66), "margin": {"l": 86, "r": 12, "t": 26, "b": 40}, "barmode": "overlay",
        "hovermode": "x", "showlegend": True, "dragmode": "zoom", "shapes": shapes,
        "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "font": {"size": 11}},
        "font": {"size": 11.5, "family": "system-ui, sans-serif"},
        "xaxis": {"title": {"text": "time [s]"}, "range": [start, end], "anchor": "free", "position": 0,
                  "zeroline": False},
    }  # fmt: skip
    top = total
    for name, (title, _) in wishes.items():
        height = heights[name]
        bottom = top - height
        axis: Figure = {
            "domain": [max(bottom / total, 0.0), max(top / total, 0.0)],
            "title": {"text": title, "standoff": 6},
        }
        axis |= {"fixedrange": True, "zeroline": name in ("y3", "y4", "y7", "y10"), "anchor": "x", "automargin": False}
        if name == "y" or not height:
            axis |= {"visible": False, "range": [0, 1]}
        if name == "y":
            axis["domain"] = [bottom / total, 1.0]
        if name in ("y5", "y8", "y9"):
            axis["rangemode"] = "tozero"
        if name == "y6" and height:
            axis |= {"type": "category", "categoryorder": "array", "categoryarray": rows[::-1], "showgrid": False}
            axis |= {"range": [-0.5, len(rows) - 0.5], "tickfont": {"size": 10.5}}
        layout["yaxis" + name.removeprefix("y")] = axis
        top = bottom - (gap if height or name == "y" else 0.0)
    return layout
