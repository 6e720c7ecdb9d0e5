"""The top view and the charts over time; `templates/run.js` and `view.js` draw them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from reports.panels.panel import Run

PLACE = 20  # on the page of a run, from the top


def values(run: Run) -> dict[str, Any]:
    """What the legend names, and whether bands of nets are there."""
    return {"legend": legend(run.data), "nets": run.nets}


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


TEMPLATE = """\
<section class="replay" id="replay">
  <div class="view">
    <div class="bar-top">
      <h2>Top view</h2>
      <span class="tools">
        <button id="follow" aria-pressed="true" title="keep the ego in the middle">Follow</button>
        <button id="whole" aria-pressed="false" title="show the whole road">Whole road</button>
        <button id="closer" title="zoom in" aria-label="zoom in">+</button>
        <button id="wider" title="zoom out" aria-label="zoom out">−</button>
      </span>
    </div>
    <canvas id="scene" tabindex="0" aria-label="Road, boxes and paths from above; drag to move, wheel to zoom"></canvas>
    <div class="player">
      <button id="play" title="space bar">▶ Play</button>
      <select id="pace" aria-label="pace"><option value="0.25">¼×</option><option value="1">1×</option><option value="2" selected>2×</option><option value="5">5×</option><option value="10">10×</option></select>
      <div class="slider"><div id="ticks"></div><input id="time" type="range" step="0.01" aria-label="time [s]"></div>
      <output id="now">0.00 s</output>
    </div>
    <dl class="readout" id="readout"></dl>
    <p class="legend">
      {% for mark, label in legend %}<span><i class="{{ mark }}"></i>{{ label }}</span>{% endfor %}

    </p>
  </div>
  <div class="charts">
    <div class="bar-top"><h2>Over time <small>click to go there{% if nets %}; bands: active places of the decision nets, hover for their names{% endif %}</small></h2><span class="tools"><button id="unzoom">Reset zoom</button></span></div>
    <div class="chart-box"><div id="chart"></div><div id="cursor"></div></div>
  </div>
</section>
"""  # noqa: E501
