"""The page of a campaign: where in the space of the parameters the stack fails, and how to see it fail again.

It holds no script and loads nothing: the plots are drawings in the page.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from markupsafe import Markup, escape

from reports.templating import asset, environment
from reports.whole_file import write_page

PLOTS = 15  # pairs of parameters that are drawn: all of six
SIZE, LEFT, LOW = 230.0, 46.0, 34.0  # px: side of a plot, and room for its axes
COLOURS = ("#c24a00", "#a2437c", "#0072b2", "#e69f00", "#56b4e9", "#8a6100", "#d55e00", "#009e73")
PASS = "#8fa3ad"
FAILS = "#c24a00"  # behind the points, at 0.35 of its strength where a failure is sure
FAINT = 0.05  # probability of a failure below which nothing is shaded


def write_campaign_page(path: str | Path, pages: Sequence[Mapping[str, Any]]) -> None:
    """Write the page; same input, same bytes.

    A page, one for each scenario, holds scenario, summary {runs, verdicts, vacuous, failures}, influence {dependent,
    drives, results, rows [{name, cells [(share, error)]}]} or None, axes [{name, low, high, nominal}], points [{values,
    verdict, cluster, objective, label}], clusters [{cluster, count, sentence, file, command, message}], probability
    {estimate, low, high, runs, failures} or None, tried [sentences],
    boundary {right, rarer, slices} or None: how often a guess was right, how many drives are of the rarer kind, and
    for each pair of axes rows of probabilities, [] where the guess tells too little.

    Raises OSError if the file cannot be written.
    """
    write_page(path, render_campaign_page(pages))


def render_campaign_page(pages: Sequence[Mapping[str, Any]]) -> str:
    """The page as text; arguments as in `write_campaign_page`."""
    drawn = []
    for page in pages:
        names = list(page["summary"]["failures"])
        colours = {name: COLOURS[k % len(COLOURS)] for k, name in enumerate(names)}
        every = list(itertools.combinations(range(len(page["axes"])), 2))
        pairs = every[:PLOTS]
        slices = (page["boundary"]["slices"] if page.get("boundary") else None) or [None] * len(pairs)
        plots = [_plot(page, i, j, colours, shaded) for (i, j), shaded in zip(pairs, slices, strict=False)]
        drawn.append({**page, "colours": colours, "plots": plots, "pairs": len(every)})
    text: str = _template().render(pages=drawn, style=Markup(asset("run.css") + asset("campaign.css")), grey=PASS)
    return text


def _plot(
    page: Mapping[str, Any], i: int, j: int, colours: Mapping[str, str], shaded: Sequence[Sequence[float]] | None
) -> Markup:
    """One parameter over another: a point for each drive, failures on top, the nominal values as a cross of lines;
    behind them, how likely a failure is where the other parameters are nominal."""
    across, up = page["axes"][i], page["axes"][j]

    def x(value: float) -> float:
        return LEFT + SIZE * _share(across, value)

    def y(value: float) -> float:
        return SIZE * (1.0 - _share(up, value)) + 6.0

    parts = [Markup('<rect class="area" x="{}" y="6" width="{}" height="{}"/>').format(LEFT, SIZE, SIZE)]
    for row, shares in enumerate(shaded or ()):
        cell = SIZE / len(shares)
        for column, share in enumerate(shares):
            if share >= FAINT:
                parts.append(Markup('<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="{}" '
                                    'fill-opacity="{:.2f}"/>').format(
                    LEFT + column * cell, SIZE + 6.0 - (row + 1) * cell, cell, cell, FAILS, 0.35 * share))  # fmt: skip
    parts.append(Markup('<line class="nominal" x1="{0:.1f}" x2="{0:.1f}" y1="6" y2="{1}"/>').format(
        x(across["nominal"]), SIZE + 6.0))  # fmt: skip
    parts.append(Markup('<line class="nominal" y1="{0:.1f}" y2="{0:.1f}" x1="{1}" x2="{2}"/>').format(
        y(up["nominal"]), LEFT, LEFT + SIZE))  # fmt: skip
    for point in page["points"]:
        failed = bool(point["cluster"])
        colour = colours.get(point["cluster"], PASS) if failed else PASS
        parts.append(
            Markup('<circle cx="{:.1f}" cy="{:.1f}" r="{}" fill="{}"{}><title>{}</title></circle>').format(
                x(point["values"][i]), y(point["values"][j]), 3.2 if failed else 1.8,
                colour if point["verdict"] != "INCONCLUSIVE" else "none",
                Markup(' stroke="#8a6100"') if point["verdict"] == "INCONCLUSIVE" else "", point["label"],
            )
        )  # fmt: skip
    bottom = SIZE + 20.0
    for text, left, anchor in ((_told(across["low"]), LEFT, "start"), (_told(across["high"]), LEFT + SIZE, "end")):
        parts.append(Markup('<text x="{}" y="{}" text-anchor="{}">{}</text>').format(left, bottom, anchor, text))
    parts.append(Markup('<text class="name" x="{}" y="{}" text-anchor="middle">{}</text>').format(
        LEFT + SIZE / 2, bottom + 12.0, across["name"]))  # fmt: skip
    for text, top in ((_told(up["high"]), 16.0), (_told(up["low"]), SIZE + 4.0)):
        parts.append(Markup('<text x="{}" y="{}" text-anchor="end">{}</text>').format(LEFT - 4.0, top, text))
    parts.append(Markup('<text class="name" transform="translate(12 {}) rotate(-90)" text-anchor="middle">{}</text>')
                 .format(SIZE / 2 + 6.0, up["name"]))  # fmt: skip
    width, height = LEFT + SIZE + 8.0, SIZE + 6.0 + LOW
    label = escape(f"{up['name']} over {across['name']}")
    return Markup('<svg viewBox="0 0 {} {}" width="{}" role="img" aria-label="{}">{}</svg>').format(
        width, height, width, label, Markup("").join(parts)
    )


def _share(axis: Mapping[str, Any], value: float) -> float:
    span = axis["high"] - axis["low"]
    return 0.5 if span <= 0.0 else min(max((value - axis["low"]) / span, 0.0), 1.0)


def _told(value: float) -> str:
    return f"{value:.3g}"


@cache
def _template() -> Any:
    return environment().get_template("campaign.html")
