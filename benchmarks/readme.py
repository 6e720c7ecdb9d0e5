"""The speed table of README.md, made from the table of docs/benchmarks.md: one measurement, told twice.

`make bench` writes both; `python -m benchmarks.readme` writes README's anew from the page as it is, without measuring.
"""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
README, PAGE = ROOT / "README.md", ROOT / "docs" / "benchmarks.md"
BEGIN, END = "<!-- speed: written by `make bench` -->", "<!-- end of speed -->"
SLALOM, ODEINT = "single-track BMW 320i at 1 kHz, slalom", "CommonRoad single-track, odeint"


class Figures:
    """Rows of the page's table: (work, unit, peer, ours, peer's figure)."""

    def __init__(self, page: str) -> None:
        cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in page.splitlines() if "|" in line]
        body = cells[2:]  # below the heading and its rule
        self._rows = [(row[0], row[2], row[4], float(row[1]), float(row[5]) if row[5] else None) for row in body]

    def ours(self, work: str, unit: str) -> list[float]:
        """Our figures of the rows whose name begins with `work`. Raises LookupError if there is none in `unit`."""
        found = [ours for name, its, _, ours, _ in self._rows if name.startswith(work) and its == unit]
        if not found:
            raise LookupError(f"{PAGE.name} has no row {work!r} in {unit}")
        return found

    def ratio(self, work: str, peer: str) -> list[float]:
        """Ours by the peer's, of the rows of a work beside a peer. Raises LookupError if there is none."""
        found = [a / b for name, _, its, a, b in self._rows if name.startswith(work) and its.startswith(peer) and b]
        if not found:
            raise LookupError(f"{PAGE.name} has no row {work!r} beside {peer!r}")
        return found


def readme_part(page: str) -> str:
    """README's table and what it was measured on, from the text of docs/benchmarks.md. Raises LookupError."""
    f = Figures(page)
    machine, state = (re.search(rf"^{word}: (.*)\.$", page, re.MULTILINE) for word in ("Machine", "State"))
    if machine is None or state is None:
        raise LookupError(f"{PAGE.name} does not say on which machine or at which state it was measured")
    mncc = f.ratio("MNCC, +-5 s, 1 h", "scipy fft")[0]
    idle = f.ours("plugin idle, pytest", "ms")[-1]  # behind that of `pytest --version`
    bare = idle / f.ratio("plugin idle, pytest", "bare pytest")[-1]
    rows = (
        ("closed loop with the full stack (20 Hz; dynamics 1 kHz), three scenarios",
         f"{_span(f.ours('closed loop', 's/s'))} simulated s per CPU s", "none has one"),
        ("twin alone, 13 effects", f"{_span(f.ours('twin, TABBY EVO', 'M steps/s'))} M steps/s",
         f"{_span(f.ratio('twin, TABBY EVO', 'scipy odeint'))}x scipy's odeint"),
        ("twin alone, no effects, 1 kHz, a slalom", f"{_span(f.ours(SLALOM, 's/s'))} simulated s per CPU s",
         f"{_span(f.ratio(SLALOM, ODEINT))}x CommonRoad's single track by odeint, "
         f"{_span(f.ratio(SLALOM, 'CommonRoad multi-body'))}x its multi-body"),
        ("time to collision of box pairs", f"{_span(f.ours('TTC', 'M pairs/s'))} M pairs/s", ""),
        ("MNCC over +-5 s of 1 h at 100 Hz", f"{_span(f.ours('MNCC, +-5 s, 1 h', 'ms'))} ms",
         f"{1.0 / mncc:.2g}x faster than scipy's FFT"),
        ("a 165 s, 50 Hz log: commands to residuals of 7 channels",
         f"{_span(f.ours('commands to residuals', 'ms'))} ms", ""),
        ("plugin when no scenario is collected", f"{_span([idle])} ms", f"bare pytest {_span([bare])} ms"),
    )  # fmt: skip
    lines = ["| work | ours | peer in the same run |", "|---|---|---|", *(f"| {' | '.join(row)} |" for row in rows)]
    return "\n".join([f"CPU time, medians, one thread; {machine[1]}; state: {state[1]}.", "", *lines])


def put(readme: str, part: str) -> str:
    """README with `part` between its marks. Raises ValueError if it has none."""
    if BEGIN not in readme or END not in readme:
        raise ValueError(f"{README.name} has no marks {BEGIN} and {END}")
    head, rest = readme.split(BEGIN, 1)
    return f"{head}{BEGIN}\n{part}\n{END}{rest.split(END, 1)[1]}"


def write() -> None:
    """Write README's table from the page as it is."""
    README.write_text(put(README.read_text(encoding="utf-8"), readme_part(PAGE.read_text(encoding="utf-8"))), "utf-8")


def _span(values: list[float]) -> str:
    """`208 to 279`, or one figure where they are alike to three digits."""
    ends = list(dict.fromkeys(_short(value) for value in (min(values), max(values))))
    return " to ".join(ends)


def _short(value: float) -> str:
    return f"{value:.3g}" if value < 1000.0 else f"{float(f'{value:.3g}'):,.0f}"


if __name__ == "__main__":
    write()
