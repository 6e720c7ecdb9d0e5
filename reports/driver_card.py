"""The driver card of a manoeuvre as one printable page: text, path on the ground, commands over time."""

from __future__ import annotations

import html

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; max-width: 60em; margin: 1.5em auto; padding: 0 1em; color: #1b1b1b; }
pre { font: 13px/1.5 ui-monospace, monospace; white-space: pre-wrap; }
svg { width: 100%; height: auto; } svg text { font: 12px system-ui, sans-serif; fill: #444; }
.path { fill: none; stroke: #0b62a4; stroke-width: 1.6; vector-effect: non-scaling-stroke; }
.ground { fill: #f4f4ef; stroke: #999; vector-effect: non-scaling-stroke; }
.zero { stroke: #ccc; vector-effect: non-scaling-stroke; } .start { fill: #c0392b; }
@media print { body { margin: 0; } }
"""
_WIDTH, _HEIGHT = 900.0, 130.0  # px of a curve


def driver_card(title: str, text: str, t: FloatArray, motion: FloatArray, wishes: FloatArray,
                area: tuple[float, ...]) -> str:  # fmt: skip
    """One HTML page that needs nothing else.

    t (n,) [s]; motion (n, 5): x, y [m], yaw [rad], v [m/s], yaw rate [rad/s]; wishes (n, 3): acceleration [m/s^2],
    road-wheel angle [rad], speed [m/s]; area: x_min, x_max, y_min, y_max [m].
    """
    curves = "".join(
        (
            _curve("speed [m/s]", t, motion[:, 3]),
            _curve("steering at the road wheels [deg], left up", t, np.degrees(wishes[:, 1])),
            _curve("acceleration asked for [m/s^2]", t, wishes[:, 0]),
        )
    )
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" '
        f'content="width=device-width"><title>{html.escape(title)}</title><style>{_STYLE}</style></head><body>'
        f"<h1>{html.escape(title)}</h1><pre>{html.escape(text)}</pre><h2>Path</h2>{_path(motion, area)}"
        f"<h2>Over time</h2>{curves}</body></html>\n"
    )


def _path(motion: FloatArray, area: tuple[float, ...]) -> str:
    x_min, x_max, y_min, y_max = area
    line = _points(motion[::10, 0], -motion[::10, 1])
    span = max(x_max - x_min, y_max - y_min)
    size = 0.012 * span
    ticks = "".join(
        f'<text x="{x:.1f}" y="{-y - size:.1f}" style="font-size:{1.6 * size:.2f}px">{10 * k} s</text>'
        for k, (x, y) in enumerate(motion[::500, :2].tolist())
    )
    return (
        f'<svg viewBox="{x_min:.1f} {-y_max:.1f} {x_max - x_min:.1f} {y_max - y_min:.1f}" role="img" '
        f'aria-label="path on the ground"><rect class="ground" x="{x_min:.2f}" y="{-y_max:.2f}" '
        f'width="{x_max - x_min:.2f}" height="{y_max - y_min:.2f}"/><polyline class="path" points="{line}"/>'
        f'<circle class="start" cx="0" cy="0" r="{size:.2f}"/>{ticks}</svg>'
    )


def _curve(label: str, t: FloatArray, values: FloatArray) -> str:
    low, high = min(float(values.min()), 0.0), max(float(values.max()), 0.0)
    scale = (_HEIGHT - 30.0) / max(high - low, 1e-9)
    across = _WIDTH / max(float(t[-1]), 1e-9)
    zero = 22.0 + high * scale
    line = _points(t[::3] * across, zero - values[::3] * scale)
    return (
        f'<svg viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" role="img" aria-label="{html.escape(label)}">'
        f'<text x="0" y="14">{html.escape(label)}: {low:.3g} to {high:.3g}, {t[-1]:.0f} s</text>'
        f'<line class="zero" x1="0" x2="{_WIDTH:g}" y1="{zero:.1f}" y2="{zero:.1f}"/>'
        f'<polyline class="path" points="{line}"/></svg>'
    )


def _points(x: FloatArray, y: FloatArray) -> str:
    return " ".join(f"{a:.2f},{b:.2f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))
