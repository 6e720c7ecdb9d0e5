"""README's speed table says what docs/benchmarks.md says, and takes each figure from its own row."""

from __future__ import annotations

import pytest

from benchmarks.__main__ import table
from benchmarks.measure import Row
from benchmarks.readme import BEGIN, END, PAGE, README, put, readme_part

SLALOM = "single-track BMW 320i at 1 kHz, slalom"
ROWS = [
    Row("closed loop, a", 210.0, "s/s"),
    Row("closed loop, b", 290.4, "s/s"),
    Row("plugin idle, pytest --version", -0.3, "ms", "", "bare pytest", 100.0),
    Row("plugin idle, pytest", 12.0, "ms", "", "bare pytest", 240.0),
    Row(SLALOM, 8000.0, "s/s", "", "CommonRoad single-track, odeint", 1000.0),
    Row(SLALOM, 8000.0, "s/s", "", "CommonRoad single-track, odeint", 500.0),
    Row(SLALOM, 8000.0, "s/s", "", "CommonRoad multi-body, RK4 1 ms", 4.0),
    Row("commands to residuals, 165 s at 50 Hz", 1.25, "ms"),
    Row("TTC, boxes within 50 m", 60.0, "M pairs/s"),
    Row("TTC, boxes within 3 m", 13.4, "M pairs/s"),
    Row("MNCC, +-5 s, 100 s at 100 Hz", 0.3, "ms", "", "scipy fft", 0.4),
    Row("MNCC, +-5 s, 1 h at 100 Hz", 5.0, "ms", "", "scipy fft", 20.0),
    Row("twin, TABBY EVO", 5.5, "M steps/s", "", "hand-written numba RK4, no effects", 7.6),
    Row("twin, TABBY EVO at 1 kHz", 5500.0, "s/s", "", "scipy odeint, Python", 550.0),
]


def test_readme_is_made_from_the_page_as_it_is() -> None:
    readme = README.read_text(encoding="utf-8")
    assert put(readme, readme_part(PAGE.read_text(encoding="utf-8"))) == readme, "python -m benchmarks.readme"


def test_every_figure_comes_from_its_own_row() -> None:
    found = {line.split(" | ")[0][2:]: line.split(" | ")[1:] for line in readme_part(table(ROWS)).splitlines()[4:]}
    figures = {work: f"{ours}; {peer.removesuffix(' |')}" for work, (ours, peer) in found.items()}
    assert list(figures.values()) == [
        "210 to 290 simulated s per CPU s; none has one",
        "5.5 M steps/s; 10x scipy's odeint",
        "8,000 simulated s per CPU s; 8 to 16x CommonRoad's single track by odeint, 2,000x its multi-body",
        "13.4 to 60 M pairs/s; ",
        "5 ms; 4x faster than scipy's FFT",
        "1.25 ms; ",
        "12 ms; bare pytest 240 ms",
    ]


def test_the_state_that_was_measured_is_named() -> None:
    assert "; state: " in readme_part(table(ROWS)).splitlines()[0]


def test_a_row_that_is_gone_is_said() -> None:
    with pytest.raises(LookupError, match="no row 'TTC' in M pairs/s"):
        readme_part(table([row for row in ROWS if not row.name.startswith("TTC")]))


def test_a_readme_without_marks_is_not_written_over() -> None:
    assert put(f"a\n{BEGIN}\nold\n{END}\nb\n", "new") == f"a\n{BEGIN}\nnew\n{END}\nb\n"
    with pytest.raises(ValueError, match="no marks"):
        put("# README\n", "new")
