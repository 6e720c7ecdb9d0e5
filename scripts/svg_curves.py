"""Panels of curves as SVG, for pages: no library, the same input gives the same bytes."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from html import escape

COLOURS = ("#0072B2", "#E69F00", "#009E73", "#D55E00")  # Okabe and Ito
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 400, 300, 62, 12, 34, 62


@dataclasses.dataclass(frozen=True, slots=True)
class Curve:
    """A step curve: its name and its points."""

    name: str
    points: Sequence[tuple[float, float]]


@dataclasses.dataclass(frozen=True, slots=True)
class Panel:
    """Axes with curves; `log`: the y axis counts decades; `span`: what it shows at least."""

    title: str
    x: str
    y: str
    log: bool
    curves: Sequence[Curve]
    span: tuple[float, ...] = ()


def curves(panels: Sequence[Panel]) -> str:
    """The panels side by side."""
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH * len(panels)} {HEIGHT}" '
        'font-family="system-ui, sans-serif" font-size="12">',
        '<rect width="100%" height="100%" fill="#ffffff"/>',
    ]
    for k, panel in enumerate(panels):
        parts += [f'<g transform="translate({k * WIDTH},0)">', *_panel(panel), "</g>"]
    return "\n".join([*parts, "</svg>"]) + "\n"


def _panel(panel: Panel) -> list[str]:
    every = [point for curve in panel.curves for point in curve.points]
    wide = max(x for x, _ in every)
    values = [math.log10(y) if panel.log else y for y in (*(y for _, y in every), *panel.span) if math.isfinite(y)]
    low, high = min(values), max(values)
    margin = 0.06 * (high - low) or 0.5
    low, high = low - margin, high + margin

    def px(x: float) -> float:
        return LEFT + (WIDTH - LEFT - RIGHT) * x / wide

    def py(y: float) -> float:
        return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * (y - low) / (high - low)

    out = [f'<text x="{LEFT}" y="20" font-weight="600" font-size="13">{escape(panel.title)}</text>']
    for tick in _ticks(low, high, panel.log):
        text = f"{10**tick:g}" if panel.log else f"{tick:g}"
        out.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{py(tick):.1f}" y2="{py(tick):.1f}" stroke="#dddddd"/>')
        out.append(f'<text x="{LEFT - 6}" y="{py(tick) + 4:.1f}" text-anchor="end">{text}</text>')
    for k in range(5):
        x = wide * k / 4
        out.append(f'<text x="{px(x):.1f}" y="{HEIGHT - BOTTOM + 16}" text-anchor="middle">{x:g}</text>')
    out.append(
        f'<text x="{(LEFT + WIDTH) / 2}" y="{HEIGHT - BOTTOM + 32}" text-anchor="middle">{escape(panel.x)}</text>'
    )
    middle = (TOP + HEIGHT - BOTTOM) / 2
    out.append(
        f'<text transform="rotate(-90 14 {middle})" x="14" y="{middle}" text-anchor="middle">{escape(panel.y)}</text>'
    )
    for k, curve in enumerate(panel.curves):
        known = [(x, math.log10(y) if panel.log else y) for x, y in curve.points if math.isfinite(y)]
        steps = [f"M{px(known[0][0]):.1f} {py(known[0][1]):.1f}"]
        steps += [f"H{px(x):.1f}V{py(y):.1f}" for x, y in known[1:]]
        out.append(f'<path d="{"".join(steps)}" fill="none" stroke="{COLOURS[k]}" stroke-width="2"/>')
        at = 14 + 138 * k
        key = f'<line x1="{at}" x2="{at + 16}" y1="{HEIGHT - 12}" y2="{HEIGHT - 12}" stroke="{COLOURS[k]}"'
        out.append(f'{key} stroke-width="3"/>')
        out.append(f'<text x="{at + 20}" y="{HEIGHT - 8}">{escape(curve.name)}</text>')
    return out


def _ticks(low: float, high: float, log: bool) -> list[float]:
    if log and high - low >= 1.0:
        return [float(k) for k in range(math.ceil(low), math.floor(high) + 1)]
    step = 10.0 ** math.floor(math.log10((high - low) / 3.0))
    step = next(s for s in (step, 2 * step, 5 * step, 10 * step) if (high - low) / s <= 5.0)
    return [round(k * step, 10) for k in range(math.ceil(low / step), math.floor(high / step) + 1)]
