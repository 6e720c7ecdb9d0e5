"""What a run left: its verdicts, its log, and the command that does it again."""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.drive.ini_file import changes_a_run
from pytest_dvp.drive.loop import Ending
from pytest_dvp.drive.replay_words import words_of_run
from pytest_dvp.logs.log import Log
from pytest_dvp.text.paths import shown

if TYPE_CHECKING:
    from pytest_dvp.drive.request import Request
    from pytest_dvp.verdicts.judging import Verdict


@dataclasses.dataclass(frozen=True)
class RunResult:
    """What a run left: the log, the verdicts of its gates, and how to do it again.

    status    PASS only if at least one gate was judged and all of them passed
    folder    run folder with log.mcap, result.json and report.html, if one was asked for
    scenario  the file as a command line names it; line: its storyboard
    ads       name of the driving stack
    ended     what ended the run, as a phrase: "the stop trigger", "the default limit of 60 s (--duration)"
    metrics   all metrics of the log by name, whether a gate judges them or not; None where undefined
    error     traceback of a stack or vehicle that broke, or the limit that ended the run
    tick_time  how long the stack took for its ticks: `pytest_dvp.drive.tick_time`
    findings  what was out of bounds and was not judged: what the stack asked for beyond the car
    compute_delay  of the commands, as `--compute-delay` takes it; None: none
    notes     what is bad and was not judged; what in the scenario is doubtful: events that never fired, acts that
              never ended
    events    names of the storyboard's events; never_fired: of those that did not, the ones that no gate lets be
    """

    log: Log
    verdicts: tuple[Verdict, ...]
    status: str
    folder: Path | None
    scenario: str
    line: int
    stage: str
    ads: str
    seed: int
    ending: Ending
    ended: str
    set: Mapping[str, str]
    replay: str
    metrics: Mapping[str, float | None]
    error: str | None = None
    notes: tuple[str, ...] = ()
    tick_time: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    findings: tuple[Mapping[str, Any], ...] = ()
    compute_delay: str | None = None
    events: tuple[str, ...] = ()
    never_fired: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON-able data: what crosses processes and stands in result.json; no series."""
        return {
            "scenario": self.scenario,
            "line": self.line,
            "stage": self.stage,
            "ads": self.ads,
            "seed": self.seed,
            "status": self.status,
            "ending": self.ending,
            "ended": self.ended,
            "simulated": self.log.duration,
            "set": dict(self.set),
            "verdicts": [verdict.as_dict() for verdict in self.verdicts],
            "metrics": dict(self.metrics),
            "folder": None if self.folder is None else shown(self.folder),
            "replay": self.replay,
            "error": self.error,
            "notes": list(self.notes),
            "tick_time": dict(self.tick_time),
            "findings": [dict(finding) for finding in self.findings],
            "compute_delay": self.compute_delay,
            "events": list(self.events),
            "never_fired": list(self.never_fired),
        }


def assigned(request: Request) -> dict[str, str]:
    """Everything that was set, under the names `--set` takes."""
    named = {name: str(value) for name, value in request.parameters.items()}
    named.update((f"P.{name}", str(value)) for name, value in request.P.items())
    named.update((f"S.{name}", str(value)) for name, value in request.S.items())
    return named


def replay_command(request: Request) -> str:
    """The `dvp run` that does the same again, or why there is none."""
    if request.ads is not None and request.ads.word is None:
        return f"no command line can name the ADS {request.ads.name}; repeat the test or script that made it"
    if request.spec.gated:
        return "no command line puts the twin behind the guard; repeat the script that made it"
    ads = None if request.ads is None else request.ads.word
    delay = None if request.compute_delay is None else str(request.compute_delay)
    words = ["dvp", "run", shown(request.path), *words_of_run(request.spec, ads, assigned(request), delay)]
    words += ["--no-ini"] if changes_a_run(words, request.spec.stage) else []
    return shlex.join(words)
