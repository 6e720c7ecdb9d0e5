"""The page of a diagnosis, from plain data: it says what was found, in numbers, and what is hostile stays text."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reports.diagnosis import ladder_figure, render_diagnosis_report, with_effects, write_diagnosis_report

HOSTILE = "</script><img src=x onerror=alert(1)>"


def effect(name: str = "steer_delay", **more: Any) -> dict[str, Any]:
    return {
        "name": name, "action": "add", "standing": "confirmed", "apart": False,
        "physics": "it comes late", "equation": "d(t) = d_c(t - T)",
        "parameters": [{"key": "T", "value": "0.249", "interval": "0.247 to 0.251", "unit": "s", "meaning": "late"}],
        "fit": {"value": 0.71, "low": 0.53, "high": 0.83, "shown": "71 %"},
        "held_out": {"value": 0.64, "low": 0.42, "high": 0.77, "shown": "64 %"},
        "rivals": [], "manoeuvre": None, "reveals": "steps of the steering", **more,
    }  # fmt: skip


def page(**more: Any) -> dict[str, Any]:
    t = np.arange(0.0, 6.0, 0.02)
    rest = {"before": 0.05 * np.sin(t), "after": 0.005 * np.cos(40.0 * t), "noise": 0.005}
    return {
        "verdict": "NAMED", "headline": "car.toml lacks steer_delay (chi²/N 65.6 -> 1.17)", "model": "car.toml",
        "logs": ["rich.csv"], "held_out": ["urban.csv"], "changed": True, "noise": "sensor noise",
        "effects": [effect()], "vetoed": [],
        "second_opinion": "agrees on steer_delay", "remarks": [], "trial": "",
        "fitted_along": [], "null_line": None, "tiles": ["yaw_rate"], "left": [], "not_excited": [],
        "ladder": [{"label": "model as given", "fit": 65.6, "held_out": 7.06},
                   {"label": "+ steer_delay", "fit": 1.17, "held_out": 1.14}],
        "signals": [{"name": "yaw_rate", "unit": "rad/s", "noise": 0.00505, "before": 0.0872, "after": 0.00536,
                     "held_before": 0.0231, "held_after": 0.00497, "chi2_before": 299.0, "chi2_after": 1.13}],
        "command": "dvp extend --model car.toml --add steer_delay", "plan": "",
        "close": {"log": "rich.csv", "held_out": False, "channel": "yaw_rate", "unit": "rad/s", "error": False, "t": t,
                  "noise": 0.005, "measured": np.sin(t), "before": np.sin(t + 0.25), "after": np.sin(t)},
        "over_time": [{"log": "rich.csv", "held_out": False, "t": t, "rows": {"yaw_rate": rest},
                       "units": {"yaw_rate": "rad/s"}, "quiet": ["ax"]}],
        **more,
    }  # fmt: skip


def visible(text: str) -> str:
    """What a reader sees of the markup, without scripts and style."""
    body = re.sub(r"<(script|style).*?</\1>", " ", text, flags=re.S)
    return " ".join(re.sub(r"<[^>]+>", " ", body).split())


def figures(text: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    assert found
    return dict(json.loads(found.group(1)))


def test_what_was_found_stands_there_in_numbers() -> None:
    seen = visible(render_diagnosis_report(page()))
    for text in ("car.toml lacks steer_delay (chi²/N 65.6 → 1.17)", "T = 0.249 s", "0.247 to 0.251", "71 %",
                 "53 % to 83 %", "64 %", "42 % to 77 %", "0.0872 → 0.00536", "0.0231 → 0.00497",
                 "dvp extend --model car.toml --add steer_delay", "agrees on steer_delay",
                 "steer_delay confirmed"):  # fmt: skip
        assert text in seen


def test_what_is_known_to_be_left_is_said_where_nothing_is_missing() -> None:
    seen = visible(render_diagnosis_report(page(effects=[], changed=False, remarks=["the known remainder: ax"])))
    assert "the known remainder: ax" in seen


def test_rivals_are_bracketed_with_the_effect_and_told_what_decides() -> None:
    rivals = [{"name": "steer_lag", "physics": "a lag"}, {"name": "tyre_relaxation", "physics": "a length"}]
    text = render_diagnosis_report(page(verdict="AMBIGUOUS", effects=[effect(rivals=rivals)]))
    assert 'class="bracket" rowspan="3"' in text
    seen = visible(text)
    assert "one of these 3" in seen
    assert "or steer_lag" in seen
    assert "or tyre_relaxation" in seen
    assert "To decide, drive: steps of the steering" in seen
    decided = render_diagnosis_report(page(effects=[effect(rivals=rivals, manoeuvre="decide.xosc")]))
    assert "To decide, drive: decide.xosc" in visible(decided)


def test_a_share_that_the_held_out_data_cannot_show_is_said_and_not_drawn_as_zero() -> None:
    text = render_diagnosis_report(page(effects=[effect(held_out=None)]))
    assert "cannot show it" in visible(text)
    assert 'class="held"' not in text


def test_an_effect_to_remove_is_not_called_lacking() -> None:
    seen = visible(render_diagnosis_report(page(effects=[effect(action="remove")])))
    assert "the car does not have it" in seen
    assert "What the model lacks" not in seen
    assert "T = 0.249" not in seen


def test_an_effect_on_detections_has_no_share_of_the_motion() -> None:
    text = render_diagnosis_report(page(effects=[effect("detection_latency", apart=True, fit=None, held_out=None)]))
    assert "judged on detected objects" in visible(text)
    assert 'class="fit"' not in text


def test_what_the_data_could_not_show_comes_with_what_would() -> None:
    hidden = [{"name": "steer_rate_limit", "physics": "hands too slow", "reveals": "quick steps"}]
    assert "steer_rate_limit hands too slow would show in: quick steps" in visible(
        render_diagnosis_report(page(not_excited=hidden))
    )


def test_an_error_without_a_name_shows_its_signature_and_no_command() -> None:
    unknown = page(verdict="UNKNOWN", changed=False, effects=[], command="", left=[("look at", "battery voltage")])
    text = render_diagnosis_report(unknown)
    assert "battery voltage" in visible(text)
    assert "dvp extend" not in text
    assert figures(text)["ladder"]["data"][0]["y"] == ["yaw_rate "]  # signal by signal: there are no steps
    assert [trace["name"] for trace in figures(text)["close"]["data"]] == ["noise ±2σ", "measured", "model as given"]


@pytest.mark.parametrize("key", ["headline", "model", "command", "plan"])
def test_a_hostile_name_is_text(key: str) -> None:
    text = render_diagnosis_report(page(**{key: HOSTILE}))
    assert "<img" not in text
    assert "&lt;img" in text


def test_a_hostile_name_is_text_in_figures_too() -> None:
    text = render_diagnosis_report(page(effects=[effect(name=HOSTILE)], ladder=[{"label": HOSTILE, "fit": 9.0,
                                                                                 "held_out": None}]))  # fmt: skip
    assert "<img" not in text
    assert figures(text)["ladder"]["data"][0]["y"] == ["&lt;/script&gt;&lt;img src=x onerror=alert(1)&gt; "]


def test_nothing_is_loaded_from_elsewhere() -> None:
    text = render_diagnosis_report(page())
    assert "default-src 'none'" in text
    markup = re.sub(r"<script>.*?</script>", "", text, flags=re.S)
    assert not re.search(r"""(src|href)\s*=\s*["']?(https?:)?//""", markup)
    assert "@import" not in markup
    assert "url(" not in markup


def test_same_data_same_bytes(tmp_path: Path) -> None:
    for name in ("one.html", "two.html"):
        write_diagnosis_report(tmp_path / name, page())
    assert (tmp_path / "one.html").read_bytes() == (tmp_path / "two.html").read_bytes()


def test_the_ladder_is_logarithmic_with_the_null_line_where_it_belongs() -> None:
    figure = ladder_figure(page()["ladder"], 41.0)
    assert figure["layout"]["xaxis"]["type"] == "log"
    assert [trace["x"] for trace in figure["data"] if trace["x"] != [None]] == [[65.6, 1.17], [7.06, 1.14]]
    lines = [shape for shape in figure["layout"]["shapes"] if shape["type"] == "line"]
    assert [(line["x0"], line["x1"]) for line in lines] == [(41.0, 41.0)]
    assert not [s for s in ladder_figure(page()["ladder"], None)["layout"]["shapes"] if s["type"] == "line"]


@pytest.mark.parametrize(("last", "first_tick"), [(1.1, 1), (0.25, 0.2), (0.04, 0.05)])
def test_a_step_far_below_the_noise_is_on_the_axis(last: float, first_tick: float) -> None:
    rungs = [{"label": "a", "fit": 60.0, "held_out": None}, {"label": "b", "fit": last, "held_out": None}]
    axis = ladder_figure(rungs, None)["layout"]["xaxis"]
    assert 10.0 ** axis["range"][0] < last
    assert axis["tickvals"][0] == first_tick


def test_labels_of_the_ladder_keep_off_the_lines_and_each_other() -> None:
    rungs = [{"label": "a", "fit": 60.0, "held_out": 7.0}, {"label": "b", "fit": 1.1, "held_out": 2.0}]
    fit, held = (trace["textposition"] for trace in ladder_figure(rungs, None)["data"])
    assert fit == ["bottom right", "top left"]  # the larger of both to the right, the smaller to the left
    assert held == ["top left", "bottom right"]


@pytest.mark.parametrize(
    ("effects", "words"),
    [
        ([effect()], "with steer_delay"),
        ([effect(action="remove")], "without steer_delay"),
        ([effect(), effect("brake_gain")], "with 2 changes"),
    ],
)
def test_the_better_model_is_called_after_what_is_new(effects: list[dict[str, Any]], words: str) -> None:
    assert with_effects(effects) == words


def test_what_an_error_of_one_is_stands_at_the_axis_and_in_the_words() -> None:
    figure = ladder_figure(page()["ladder"], None, noise="noise and remainder")["layout"]
    assert figure["xaxis"]["title"]["text"] == "error, chi²/N (1 = noise and remainder)"
    assert [note["text"] for note in figure["annotations"]] == ["about noise and remainder"]
    text = render_diagnosis_report({**page(), "noise": "noise and remainder"})
    assert "in units of the noise and remainder" in text
    assert "in units of the sensor noise" in render_diagnosis_report(page())
