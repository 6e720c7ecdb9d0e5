"""Build sdist and wheel, and try the wheel in an empty environment from an empty folder.

    python -m scripts.try_wheel

The wheel is built from the sdist, so that both are known to be whole. Both are left in dist/. A new environment gets
the wheel and its dependencies in the versions of constraints.txt; there, outside of the checkout, `dvp` and pytest run.
Ends with the exit code of the first command that fails.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import tomllib
import venv
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DIST = ROOT / "dist"
KEPT_OUT = ("PYTHONPATH", "DVP_ROOMS", "VIRTUAL_ENV")
"""Environment variables by which the checkout could be found in place of the wheel."""


def build() -> Path:
    """Build sdist, then from it the wheel, without a network; returns the wheel."""
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    source, wheel = DIST / f"pytest_dvp-{version}.tar.gz", DIST / f"pytest_dvp-{version}-py3-none-any.whl"
    for old in (source, wheel):
        old.unlink(missing_ok=True)
    _call([sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", str(DIST)], ROOT)
    _call(
        [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", str(DIST), str(source)],
        ROOT,
    )
    return wheel


def try_out(wheel: Path, place: Path) -> None:
    """Install the wheel into a new environment below `place`, and use it from an empty folder there."""
    venv.create(place / "env", with_pip=True)
    programs, empty = place / "env" / "bin", place / "empty"
    empty.mkdir()
    constraints = str(ROOT / "constraints.txt")
    _call([str(programs / "python"), "-m", "pip", "install", "-q", "-c", constraints, str(wheel)], empty)
    dvp = str(programs / "dvp")
    _call([dvp, "--version"], empty)
    shipped = _said([str(programs / "python"), "-c", "import scenarios; print(scenarios.path('follow.xosc'))"], empty)
    if not Path(shipped).is_relative_to(place):
        raise SystemExit(f"scenarios come from {shipped}, not from the wheel")
    _call([dvp, "check", shipped], empty)
    _call([dvp, "run", shipped, "--duration", "5"], empty, allowed=(0, 1))  # 5 s are too short for its events
    if not (empty / "runs" / "0001-follow-dt" / "report.html").is_file():
        raise SystemExit("dvp run has written no report")
    _call([str(programs / "pytest"), "-q", "-m", "dt", shipped, "--rootdir", str(empty)], empty)


def _call(command: Sequence[str], folder: Path, allowed: Sequence[int] = (0,)) -> None:
    print("$", *(Path(command[0]).name, *command[1:]), flush=True)
    code = subprocess.run(command, cwd=folder, env=_environment(), check=False).returncode
    if code not in allowed:
        raise SystemExit(code)


def _said(command: Sequence[str], folder: Path) -> str:
    return subprocess.run(
        command, cwd=folder, env=_environment(), check=True, capture_output=True, text=True
    ).stdout.strip()


def _environment() -> dict[str, str]:
    return {name: value for name, value in os.environ.items() if name not in KEPT_OUT}


def main() -> int:
    wheel = build()
    with tempfile.TemporaryDirectory(prefix="dvp-wheel-") as place:
        try_out(wheel, Path(place).resolve())
    print(f"{wheel.relative_to(ROOT)} works in an empty environment")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
