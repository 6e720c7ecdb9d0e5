"""The run report: one file, nothing from a network, nothing obeyed that comes from a user's file."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contents import contents

from reports.embed import embed
from reports.html import render_run_report, write_run_report
from reports.panels.conditions import conditions

MakeRun = Callable[..., dict[str, Any]]
EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\u2028${7*7}{{7*7}}"


class Elements(HTMLParser):
    """Start tags with their attributes, and the text of scripts."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[str] = []
        self.text = ""
        self._in: str | None = None

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self._in = tag
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag: str) -> None:
        self._in = None

    def handle_data(self, data: str) -> None:
        if self._in == "script":
            self.scripts[-1] += data
        elif self._in != "style":
            self.text += data


def parse(page: str) -> Elements:
    elements = Elements()
    elements.feed(page)
    return elements


@pytest.fixture(autouse=True)
def without_plotly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its 5 MB would only be parsed again and again here; test_size.py and the browser's tests have it."""
    monkeypatch.setattr("reports.frame.plotly_js", lambda: "/* plotly */")
    monkeypatch.setattr("reports.frame.packed_plotly", lambda: "")


def test_page_loads_nothing(make_run: MakeRun) -> None:
    tags = parse(render_run_report(**make_run())).tags
    assert not [tag for tag, attributes in tags if {"src", "href", "action", "data"} & attributes.keys()]
    assert not [tag for tag, _ in tags if tag in ("link", "iframe", "object", "embed", "img", "base")]


def test_page_of_a_folder_of_runs_loads_the_shared_library_and_nothing_else(make_run: MakeRun) -> None:
    tags = parse(render_run_report(**make_run(), library="../assets/plotly-1.min.js")).tags
    assert [attributes["src"] for _, attributes in tags if "src" in attributes] == ["../assets/plotly-1.min.js"]
    assert not [tag for tag, attributes in tags if {"href", "action", "data"} & attributes.keys()]


def test_only_a_nonce_that_all_data_decide_allows_the_shared_library(make_run: MakeRun) -> None:
    def nonce(run: dict[str, Any]) -> str | None:
        tags = parse(render_run_report(**run, library="../assets/plotly-1.min.js")).tags
        policy = next(attributes["content"] for _, attributes in tags if "http-equiv" in attributes)
        (script,) = [attributes for tag, attributes in tags if tag == "script" and "src" in attributes]
        assert policy is not None
        assert f"'nonce-{script['nonce']}'" in policy
        assert policy.count("'sha256-") == 3
        assert not {"'self'", "file:", "'unsafe-inline'"} & set(policy.split("script-src")[1].split(";")[0].split())
        return script["nonce"]

    run = make_run()
    first = nonce(run)
    run["objects"][0]["name"] = f"a text that names the nonce of another page, {first}"
    assert nonce(run) != first


def test_same_input_same_bytes(make_run: MakeRun, tmp_path: Path) -> None:
    for name in ("a.html", "b.html"):
        write_run_report(tmp_path / name, **make_run())
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_verdict_stands_in_the_header(make_run: MakeRun) -> None:
    page = render_run_report(**make_run("FAIL"))
    header = re.search(r"<header.*?</header>", page, re.S)
    assert header is not None
    text = parse(header[0]).text
    assert "FAIL" in text
    assert "max_ttc_inverse 1.31 1/s (must be ≤ 0.5) at 15.40 s, Pedestrian" in text


def test_the_command_to_replay_stands_under_the_headline_with_the_stack(make_run: MakeRun) -> None:
    run = make_run()
    run["result"] |= {"ads": "my.stack:Stack", "replay": "dvp run <x>.xosc --ads my.stack:Stack"}
    page = render_run_report(**run)
    said = "ADS my.stack:Stack · replay: <code>dvp run &lt;x&gt;.xosc --ads my.stack:Stack</code>"
    assert page.index('class="headline"') < page.index(said) < page.index("</header>")


def test_text_from_files_cannot_become_markup(make_run: MakeRun) -> None:
    run = make_run()
    clean = [tag for tag, _ in parse(render_run_report(**run)).tags]
    run["result"]["scenario"] = EVIL
    run["result"]["verdicts"][0] |= {"status": "FAIL", "object": EVIL, "message": EVIL, "file": EVIL, "t": 3.0}
    run["meta"] |= {"scenario": EVIL, "parameters": dict.fromkeys(run["meta"]["parameters"], EVIL)}
    run["objects"][0]["name"] = EVIL
    run["objects"][0]["kind"] = EVIL
    run["events"][1] |= {"element": EVIL, "file": EVIL, "text": EVIL + " -> runningState"}
    run["road"][0]["kind"] = EVIL
    run["columns"][f"ads.net.{EVIL}.{EVIL}"] = np.ones(len(run["columns"]["t"]))
    run["result"]["metrics"]["completion_time"]["object"] = EVIL
    tags = [tag for tag, _ in parse(render_run_report(**run)).tags]
    assert tags.count("script") == clean.count("script") == 5
    assert "img" not in tags
    assert "49" not in re.findall(r"\{\{7\*7\}\}|49", parse(render_run_report(**run)).text)


def test_policy_allows_exactly_our_four_scripts(make_run: MakeRun) -> None:
    elements = parse(render_run_report(**make_run()))
    policy = next(attributes["content"] for tag, attributes in elements.tags if "http-equiv" in attributes)
    assert policy is not None
    assert policy.count("'sha256-") == 4
    assert "default-src 'none'" in policy
    assert "unsafe-inline" not in policy.split("script-src")[1].split(";")[0]


def test_embedded_data_is_json_that_a_parser_gives_back() -> None:
    text = embed({"name": EVIL, "numbers": [1.5, None]})
    assert not set("<>&\u2028") & set(text)
    assert json.loads(text) == {"name": EVIL, "numbers": [1.5, None]}


def test_embedding_refuses_nan() -> None:
    with pytest.raises(ValueError, match="JSON"):
        embed([float("nan")])


def test_signals_that_were_not_measured_are_gaps(make_run: MakeRun) -> None:
    run = make_run()
    run["columns"]["ax"][100:200] = np.nan
    run["columns"]["steer"][:] = np.nan
    data = contents(render_run_report(**run))
    drawn = {trace["hovertemplate"].split(" %")[0]: trace for trace in data["figure"]["data"] if "mode" in trace
             and trace["mode"] == "lines"}  # fmt: skip
    assert None in drawn["acceleration"]["y"]
    assert "steer" not in drawn


def test_run_without_samples_still_gives_a_page(make_run: MakeRun) -> None:
    run = make_run("ERROR")
    run |= {"columns": {"t": np.zeros(0)}, "objects": [], "detections": {}, "paths": [], "events": [], "road": []}
    run["result"] |= {"verdicts": [], "metrics": {}}
    assert "No gate was judged" in parse(render_run_report(**run)).text


def test_conditions_show_every_parameter(make_run: MakeRun) -> None:
    text = html.unescape(render_run_report(**make_run()))
    for name in ("trigger_distance", "LQR_q11", "EGO_mass", "scenario_sha256", "numpy"):
        assert name in text


def test_conditions_keep_what_they_do_not_know() -> None:
    assert ("Run", [("seed", "7"), ("novelty", "yes")]) in conditions({"seed": 7, "novelty": "yes"})


def test_failed_write_leaves_nothing(make_run: MakeRun, tmp_path: Path) -> None:
    (tmp_path / "report.html").mkdir()
    with pytest.raises(OSError, match=r"report\.html"):
        write_run_report(tmp_path / "report.html", **make_run())
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]
