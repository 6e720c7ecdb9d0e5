"""The answers to logs of cars with hidden effects are those of the page: what names them must not be lost unseen.

A change of one effect had once cost another one's name for a day: its new form could not do what the old one did.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pytest_dvp.gap.diagnose.diagnose import diagnose
from pytest_dvp.logs.read_log import read_log
from vehicle.model.model_file import read_model

ROOT = Path(__file__).resolve().parents[2]
BLIND = ROOT.parent / "shared" / "blind"
ANSWERS = [json.loads(line) for line in (ROOT / "docs" / "blind.jsonl").read_text("utf-8").splitlines()]


@pytest.mark.skipif(not BLIND.is_dir(), reason="../shared is not there")
@pytest.mark.parametrize("answer", ANSWERS[::-1], ids=lambda answer: str(answer["case"]))
@pytest.mark.nightly(by_day=8)
def test_a_blind_case_is_answered_as_on_the_page(answer: dict[str, object]) -> None:
    folder = BLIND / str(answer["case"])
    logs = {name: read_log(folder / name) for name in ("rich.csv", "urban.csv")}
    found = diagnose(logs, read_model(BLIND / "model.toml")).as_dict()
    named = [[(effect["name"], effect["standing"]) for effect in one["effects"]] for one in (found, answer)]  # type: ignore[attr-defined]
    assert (found["verdict"], named[0]) == (answer["verdict"], named[1])
