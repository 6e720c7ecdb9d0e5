"""The report of one run: a page without network access, for a browser of today, of at most 400 kB beside its library.

Everything that comes from a user's file is data: it reaches the page through Jinja's escaping or inside one JSON block
whose `<`, `>` and `&` are escaped, and the page's scripts write it with `textContent`. A content security policy
(`reports/frame.py`) stands behind that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Unpack

from reports.beliefs import belief_rows
from reports.embed import compact, embed
from reports.figures import place_shares, timeline
from reports.frame import frame
from reports.nets import drawings
from reports.run_data import RunData
from reports.scene import scene
from reports.templating import environment
from reports.verdicts import Row, headline, pretty_unit, rows
from reports.whole_file import write_page

MAX_DATA_BYTES = 310_000  # leaves 90 kB of the 400 kB of a page for its tables, drawings, styles and scripts

_TOO_LONG = {("model", "toml")}  # conditions that are whole files

STATUS_SIGNS = {"PASS": "✓", "FAIL": "✗", "INCONCLUSIVE": "?", "ERROR": "!"}


def write_run_report(
    path: str | Path, result: Mapping[str, Any], *, library: str | None = None, **run: Unpack[RunData]
) -> None:
    """Write the report of one finished run; same input, same bytes. The file appears whole or not at all.

    Args:
        result: {"status", "scenario", "stage", "seed", "verdicts": [mapping], "metrics": {name: {"value", "unit", "t",
            "object", "valid", "series": {"t", "value"} or None}}}; if known also "notes": [str], "ended": str.
        library: address of the drawing library relative to the page (`frame.place_library`); None: in the page itself,
            which then needs no other file.
        run: what happened, see `RunData`.

    Raises:
        OSError: the file cannot be written.
    """
    write_page(path, render_run_report(result, library=library, **run))


def render_run_report(result: Mapping[str, Any], *, library: str | None = None, **run: Unpack[RunData]) -> str:
    """The page as text; arguments as in `write_run_report`."""
    columns, events, meta = run["columns"], run["events"], run["meta"]
    table = rows(result.get("verdicts", ()))
    metrics = result.get("metrics", {})
    ttc = metrics.get("max_ttc_inverse") or {}
    figure = None
    if len(columns.get("t", ())):
        bound = next((row.bound for row in table if row.metric == "max_ttc_inverse"), None)
        figure = timeline(columns, ttc_inverse=ttc.get("series"), ttc_bound=bound, events=events,
                          more=belief_rows(metrics, columns))  # fmt: skip
    stride = 1
    while True:
        data = scene(run, ttc.get("series"), stride)
        data |= {"figure": figure, "marks": [row.mark() for row in table if row.t is not None]}
        slim = compact(data)
        if len(embed(slim)) <= MAX_DATA_BYTES or stride >= 64:
            break
        stride *= 2
    page: str = _template().render(
        result=result,
        title=f"{result.get('scenario', '')} · {result.get('stage', '')}",
        sign=STATUS_SIGNS.get(str(result.get("status")), "?"),
        signs=STATUS_SIGNS,
        headline=headline(str(result.get("status", "")), table),
        rows=table,
        metrics=_metric_rows(metrics, table),
        conditions=conditions(meta),
        nets=drawings(_nets(meta), place_shares(columns)),
        legend=legend(data),
        duration=float(columns["t"][-1]) if len(columns.get("t", ())) else 0.0,
        **frame(slim, ["view.js", "run.js"], ["run.css"], library),
    )
    return page


def legend(data: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(CSS classes, label) of what the top view of this run shows, and of nothing else."""
    kinds = {entry["kind"] for entry in data["objects"]}
    entries = [
        ("box ego", "ego", True),
        *(("box " + kind, kind, kind in kinds) for kind in ("vehicle", "pedestrian", "bicycle", "misc")),
        ("box detected", "detected", bool(data["detections"]["t"])),
        ("line driven", "driven", True),
        ("box estimated", "estimated pose", "ads.x" in data["ego"]),
        ("line planned", "planned", bool(data["paths"]["t"])),
        ("diamond worst", "worst moments", bool(data["marks"])),
        ("diamond event", "storyboard event", bool(data["events"])),
    ]
    return [(mark, label) for mark, label, is_there in entries if is_there]


def conditions(meta: Mapping[str, Any]) -> list[tuple[str, list[tuple[str, str]]]]:
    """(heading, rows) of what the run was made of, in reading order; what has no group of its own comes last."""
    single: list[tuple[str, str]] = []
    groups: list[tuple[str, list[tuple[str, str]]]] = []
    names = {"parameters": "Scenario parameters", "P": "ADS parameters (P)", "S": "Simulator parameters (S)",
             "task": "Task", "ego": "Ego", "versions": "Versions", "model": "Vehicle model",
             "timing": "Real time [s]"}  # fmt: skip
    shown = [key for key in meta if key not in ("nets", *names)]  # the nets are drawn
    for key in [*(key for key in names if key in meta), *shown]:
        value = meta[key]
        if isinstance(value, Mapping):
            entries = [(str(name), _text(entry)) for name, entry in value.items() if (key, name) not in _TOO_LONG]
            groups.append((names.get(key, key), entries or [("all at their defaults", "")]))
        else:
            single.append((names.get(key, key), _text(value)))
    return [("Run", single), *groups] if single else groups


def _nets(meta: Mapping[str, Any]) -> list[Any]:
    nets = meta.get("nets")
    return list(nets) if isinstance(nets, list | tuple) else []


def _text(value: Any) -> str:
    if value is None or value in ("", (), []):
        return "–"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_text(entry)}" for key, entry in value.items())
    if isinstance(value, (list, tuple)):
        return ", ".join(_text(entry) for entry in value)
    return str(value)


def _metric_rows(metrics: Mapping[str, Mapping[str, Any]], table: Sequence[Row]) -> list[dict[str, Any]]:
    """Metrics that no gate looks at: they are shown, not judged."""
    gated = {row.metric for row in table}
    return [{"name": name, **value} for name, value in sorted(metrics.items()) if name not in gated]


@cache
def _template() -> Any:
    made = environment()
    made.filters["unit"] = pretty_unit
    made.filters["short"] = lambda value: "–" if value is None else f"{value:.4g}"
    return made.get_template("run.html")
