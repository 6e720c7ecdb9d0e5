"""Study files (TOML) of `dvp tune`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pytest_dvp.tuning.objective import Kind
from pytest_dvp.tuning.searchers import search_names
from pytest_dvp.tuning.study import Study
from pytest_dvp.tuning.toml_reader import Reader

_TOP = ("study", "scenario", "parameters", "fixed", "term", "constraint")
_STUDY = ("objective", "search", "budget", "seed", "seeds", "stage", "model", "vehicle", "preset", "logs", "library",
          "ads")  # fmt: skip
_KINDS: tuple[Kind, ...] = ("performance", "alignment")


def read_study(path: Path, **changes: Any) -> Study:
    """A study from its file; `changes` of search, budget, seed from the command line. Raises TuneError, one line."""
    return _StudyReader(path).study({k: v for k, v in changes.items() if v is not None})


class _StudyReader(Reader):
    def study(self, changes: Mapping[str, Any]) -> Study:
        self.tables_of(_TOP, "a study")
        head = self.table(self.data.get("study", {}), "study")
        self.known(head, _STUDY, "key of [study]")
        kind = self.word(head, "objective", _KINDS, "performance")
        preset = self.whole(head, "preset", 10, (1, 5, 10))
        stage = self.word(head, "stage", ("dt", "pe", "rw"), "dt")
        if "ads" in head:
            if kind == "alignment":
                self.fail("ads", "ads: an alignment replays logs, no stack drives")
            self.ads = self.stack(str(head["ads"]))
        P, S = self.presets(kind, preset, stage, bool("preset" in head))
        if kind == "alignment":
            for word, what in (("logs", "recorded logs: logs = [...]"), ("model", "the twin: model = ...")):
                if not head.get(word):
                    self.fail("objective", f"an alignment needs {what} in [study]")
            for name in self.data.get("parameters", {}):
                if name.startswith("P."):
                    self.fail(name, f"{name}: alignment is scored open loop, where P moves nothing; tune S")
        knobs, start = self.knobs({**P, **S})
        fixed = {
            name: self.number(value, name) for name, value in self.table(self.data.get("fixed", {}), "fixed").items()
        }
        for name in fixed:
            if name in start:
                self.fail(name, f"{name} stands in [parameters] and in [fixed], expected in one of them")
        held = {name: value for name, value in {**P, **S, **fixed}.items() if name not in start}
        self.allowed({**held, **start})
        search = str(changes.get("search", self.word(head, "search", search_names(), "coordinate")))
        study = Study(
            name=self.path.stem,
            objective=self.objective(kind),
            knobs=knobs,
            start=start,
            search=search,
            budget=int(changes.get("budget", self.whole(head, "budget", 200, least=1))),
            seed=int(changes.get("seed", self.whole(head, "seed", 1))),
            stage=stage,
            variants=self.variants(),
            seeds=tuple(self.wholes(head, "seeds", (7,))),
            logs=tuple(self.file(name, "log") for name in self.words(head, "logs")),
            model=self.file(head["model"], "model") if "model" in head else None,
            vehicle=self.vehicle(str(head.get("vehicle", "surrogate"))),
            fixed_P={n[2:]: v for n, v in held.items() if n.startswith("P.")},
            fixed_S={n[2:]: v for n, v in held.items() if n.startswith("S.")},
            ads=None if self.ads is None else self.ads.word,
            library=tuple(self.file(name, "folder") for name in self.words(head, "library")),
        )
        self.whole_study(study)
        return study

    def whole_study(self, study: Study) -> None:
        """What can only be said of all of it."""
        if study.objective.kind == "performance" and not study.variants:
            self.fail("study", "a performance needs scenarios: [[scenario]] file = ...")
        if study.stage != "dt" and any(name.startswith("S.") for name in (*study.start, *study.fixed_S)):
            self.fail("stage", f"S changes the twin; the car of stage {study.stage} is what it is")
        if study.jobs_a_point > study.budget:
            self.fail(
                "budget",
                f"budget is {study.budget}, and one point takes {study.jobs_a_point} simulations "
                "(scenarios times seeds, or logs)",
            )
