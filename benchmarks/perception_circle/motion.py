"""The surrogate's motion, learnt from its logs before its perception is looked at.

A twin that drives otherwise sees otherwise: one from a bare data sheet is 6 m elsewhere after 40 s.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

DRIVES = (("rich", 1), ("urban", 2))  # seeds; the first to fit on, the other held out
DVP = ("-c", "import sys; from pytest_dvp.cli.command_line import main; sys.exit(main())")


def learn_motion(model: Path, folder: Path) -> Path:
    """The twin `model`, extended by all that a diagnosis of two drives of the surrogate names; written in `folder`.

    Raises RuntimeError if a command fails.
    """
    folder.mkdir(parents=True, exist_ok=True)
    logs = {name: folder / f"{name}.csv" for name, _ in DRIVES}
    for name, seed in DRIVES:
        _done("-m", "vehicle.surrogate", "--drive", name, "--seed", str(seed), "--out", str(logs[name]))
    judged = ("--held-out", str(logs["urban"]), "--model", str(model))
    found = json.loads(_done(*DVP, "diagnose", str(logs["rich"]), *judged, "--json"))
    names = [effect["name"] for effect in found["effects"] if effect["action"] != "remove"]
    learnt = folder / "learnt.toml"
    _done(*DVP, "extend", "--fit", str(logs["rich"]), *judged, "--add", *names, "--out", str(learnt), "--force")
    return learnt


def _done(*words: str) -> str:
    """Standard output of this Python with these words. An open question (exit code 1 of a diagnosis) is an answer."""
    ended = subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False)
    if ended.returncode not in (0, 1) or (not ended.stdout and ended.returncode):
        raise RuntimeError(f"{' '.join(words)} ended with {ended.returncode}: {ended.stderr[-2000:]}")
    return ended.stdout
