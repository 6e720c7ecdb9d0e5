"""The report of one run: a page without network access, for a browser of today, of at most 400 kB beside its library.

Everything that comes from a user's file is data: it reaches the page through Jinja's escaping or inside one JSON block
whose `<`, `>` and `&` are escaped, and the page's scripts write it with `textContent`. A content security policy
(`reports/frame.py`) stands behind that.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, Unpack

from markupsafe import Markup

from reports.beliefs import belief_rows
from reports.embed import compact, embed
from reports.figures import place_shares, timeline
from reports.frame import frame
from reports.nets import drawings
from reports.panels.panel import Run, draw, styles
from reports.run_data import RunData
from reports.scene import scene
from reports.templating import environment
from reports.verdicts import STATUS_SIGNS, headline, rows
from reports.whole_file import write_page

MAX_DATA_BYTES = 310_000  # leaves 90 kB of the 400 kB of a page for its tables, drawings, styles and scripts


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
        data |= {"figure": figure, "marks": [row.mark() for row in table if row.t is not None and not row.is_folded]}
        slim = compact(data)
        if len(embed(slim)) <= MAX_DATA_BYTES or stride >= 64:
            break
        stride *= 2
    nets = drawings(_nets(meta), place_shares(columns))
    shown = Run(result, columns, run["objects"], events, meta, rows=table, nets=nets, data=data)
    framed = frame(slim, ["view.js", "run.js"], ["run.css"], library)
    page: str = _template().render(
        result=result,
        title=f"{result.get('scenario', '')} · {result.get('stage', '')}",
        sign=STATUS_SIGNS.get(str(result.get("status")), "?"),
        headline=headline(str(result.get("status", "")), table),
        panels=draw(shown),
        duration=float(columns["t"][-1]) if len(columns.get("t", ())) else 0.0,
        **{**framed, "style": framed["style"] + Markup(styles())},
    )
    return page


def _nets(meta: Mapping[str, Any]) -> list[Any]:
    nets = meta.get("nets")
    return list(nets) if isinstance(nets, list | tuple) else []


@cache
def _template() -> Any:
    return environment().get_template("run.html")
