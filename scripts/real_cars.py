"""What `dvp diagnose` finds on logs of three real cars:  python -m scripts.real_cars [--write] [STUDY ...]

Prints the tables of docs/real-cars.md, or with --write puts them there. The logs are not part of the project: they are
read from the folder `measurements` of the reference material at DVP_SHARED, ../shared unless set.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from pytest_dvp.gap.compare.position_error import AHEAD, position_error

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.diagnosis import Diagnosis
    from pytest_dvp.logs.log import Log
    from vehicle.model.vehicle_model import VehicleModel

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "real-cars.md"

Values: TypeAlias = Mapping[tuple[str, str], float]


@dataclasses.dataclass(frozen=True, slots=True)
class Study:
    """One diagnosis: a car's folder, the logs fitted on and held out (LOG or LOG@0:285), and the columns that drive the
    model along the road in place of those of its file (as TOML, "" for those of the file)."""

    name: str
    folder: str
    fitted: tuple[str, ...]
    held_out: tuple[str, ...]
    longitudinal: str = ""

    def logs(self, folder: Path, *, held_out: bool = False) -> dict[str, Log]:
        """The logs by name; `folder` holds the cars' folders. Raises LogError."""
        from pytest_dvp.doctor.checked_log import read_checked_log

        names = self.held_out if held_out else self.fitted
        return {name: read_checked_log(folder / self.folder / name)[0] for name in names}

    def model(self, folder: Path) -> VehicleModel:
        """The given model, with this study's columns. Raises ModelError."""
        from vehicle.model.model_file import read_model

        text = (folder / self.folder / "model.toml").read_text(encoding="utf-8")
        if self.longitudinal:
            text = re.sub(r"(?m)^longitudinal = .*$", f"longitudinal = {self.longitudinal}", text)
        with TemporaryDirectory() as place:
            file = Path(place) / "model.toml"
            file.write_text(text, encoding="utf-8")
            return read_model(file)


_RUNS = ("09_16_2024_10_01_01.csv", "09_16_2024_10_27_02.csv")
_PEDALS = '"throttle_cmd + brake_pressure"'
STUDIES = (
    Study("genesis-lap-to-path1", "genesis_g80", ("cpg_slow_lap.csv",), ("rfs_path1.csv",)),
    Study("genesis-lap-to-path3", "genesis_g80", ("cpg_slow_lap.csv",), ("rfs_path3.csv",)),
    Study("genesis-path1-to-path3", "genesis_g80", ("rfs_path1.csv",), ("rfs_path3.csv",)),
    Study("genesis-path3-to-path1", "genesis_g80", ("rfs_path3.csv",), ("rfs_path1.csv",)),
    Study("genesis-both-to-path3", "genesis_g80", ("cpg_slow_lap.csv", "rfs_path1.csv"), ("rfs_path3.csv",)),
    Study("putnam-lateral", "iac_av21_putnam", ("run4_2.csv@0:285",), ("run4_2.csv@285:",)),
    Study("putnam-longitudinal", "iac_av21_putnam", ("run4_2.csv@0:285",), ("run4_2.csv@285:",), _PEDALS),
    Study("dart-lateral", "dart_jetracer", _RUNS, ("09_16_2024_10_12_05.csv",)),
    Study("dart-longitudinal", "dart_jetracer", _RUNS, ("09_16_2024_10_12_05.csv",), '"throttle_cmd"'),
)


def tables(study: Study, found: Diagnosis, positions: tuple[float, float]) -> str:
    """The study as markdown. positions: position error on held-out data before and after, [m]."""
    from pytest_dvp.gap.compare.segments import UNITS

    before, after = found.ladder[0], found.ladder[-1]
    lines = [f"Fitted on {_files(study.fitted)}, held out {_files(study.held_out)}. Verdict: {found.verdict}.", ""]
    lines += ["| RMSE, held out | model as given | with what was found | change | change, fitted |"]
    lines += ["|---|---|---|---|---|"]
    for name in after.held_out_rmse:
        old, new = before.held_out_rmse[name], after.held_out_rmse[name]
        fitted = _change(before.rmse[name], after.rmse[name]) if name in after.rmse else "-"
        lines.append(f"| {name} [{UNITS[name]}] | {old:.4g} | {new:.4g} | {_change(old, new)} | {fitted} |")
    lines.append(
        f"| position after {AHEAD:.0f} s [m] | {positions[0]:.3g} | {positions[1]:.3g} | {_change(*positions)} | |"
    )
    lines.append(f"| chi²/N | {before.held_out_chi2_per_n or 0.0:.3g} | {after.held_out_chi2_per_n or 0.0:.3g} | | |")
    return "\n".join([*lines, "", *_effects(found), "", *_notes(found)])


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the studies; 2 if the logs are not there or a name is wrong."""
    parser = argparse.ArgumentParser(prog="python -m scripts.real_cars", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("studies", nargs="*", metavar="STUDY", help=f"of {', '.join(s.name for s in STUDIES)}")
    parser.add_argument("--write", action="store_true", help=f"put the tables into {PAGE.relative_to(ROOT)}")
    given = parser.parse_args(arguments)
    unknown = set(given.studies) - {s.name for s in STUDIES}
    if unknown:
        print(f"no study {', '.join(sorted(unknown))}; there are {', '.join(s.name for s in STUDIES)}", file=sys.stderr)
        return 2
    folder = Path(os.environ.get("DVP_SHARED", ROOT.parent / "shared")) / "measurements"
    if not folder.is_dir():
        print(f"no logs at {folder} (set DVP_SHARED)", file=sys.stderr)
        return 2
    for study in STUDIES:
        if given.studies and study.name not in given.studies:
            continue
        text = _studied(study, folder)
        if given.write:
            PAGE.write_text(placed(PAGE.read_text(encoding="utf-8"), study.name, text), encoding="utf-8")
        print(f"## {study.name}\n\n{text}\n", flush=True)
    return 0


def placed(page: str, name: str, text: str) -> str:
    """The page with the text between the study's marks. Raises ValueError if it has none."""
    start, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
    if start not in page or end not in page:
        raise ValueError(f"{PAGE.name} has no marks for {name}")
    head, rest = page.split(start, 1)
    return f"{head}{start}{text}\n{end}{rest.split(end, 1)[1]}"


def _studied(study: Study, folder: Path) -> str:
    from pytest_dvp.gap.diagnose.diagnose import diagnose
    from pytest_dvp.gap.diagnose.run_setup import end_of_beginning
    from pytest_dvp.logs.log_part import cut_log

    model, held_out = study.model(folder), study.logs(folder, held_out=True)
    found = diagnose(study.logs(folder), model, held_out)
    if found.set_up:  # as everything else that is said of the run: without the beginning that its set-up is from
        held_out = {name: cut_log(log, end_of_beginning(log), np.inf) for name, log in held_out.items()}
    errors = []
    for one in (found.ladder[0], found.ladder[-1]):
        logs = [({name: log}, run) for (name, log), run in zip_longest(held_out.items(), one.held_out_setups)]
        errors.append([position_error(log, model, _with_setup(one.values, run)) for log, run in logs])
    first, last = (float(np.sqrt(np.mean(np.square(each)))) for each in errors)
    return tables(study, found, (first, last))


def _with_setup(values: Values, run: Values | None) -> Values:
    from vehicle.model.effect_catalogue import run_setups

    return values if run is None else {k: v for k, v in values.items() if k[0] not in run_setups()} | dict(run)


def _effects(found: Diagnosis) -> Iterator[str]:
    from pytest_dvp.gap.words.diagnosis import interval

    yield "| found | key | value | 95 % interval | unit | explains, fitted | chi²/N taken away, held out | rivals |"
    yield "|---|---|---|---|---|---|---|---|"
    for key, estimate in found.input_map.items():
        yield f"| input map | `{key}` | {estimate.value:.4g} | {interval(estimate)} | {estimate.unit} | | | |"
    for effect in found.effects:
        gain = "-" if effect.held_out_gain is None else f"{effect.held_out_gain:.3g}"
        rivals = ", ".join(f"`{r}`" for r in effect.rivals) or "-"
        for k, (key, estimate) in enumerate(effect.parameters.items()):
            rest = f"{100.0 * effect.gain:.0f} % | {gain} | {rivals}" if k == 0 else "| |"
            name = f"{effect.action} `{effect.name}`"
            yield f"| {name} | `{key}` | {estimate.value:.4g} | {interval(estimate)} | {estimate.unit} | {rest} |"


def _notes(found: Diagnosis) -> Iterator[str]:
    if found.set_up:
        names = ", ".join(f"`{name}`" for name in found.set_up)
        yield f"- Of the run, not of the car (the values above are those of the fitted run): {names}."
        for run in found.ladder[-1].held_out_setups:
            own = ", ".join(f"`{name}` `{key}` {value:.3g}" for (name, key), value in run.items()) or "nothing"
            yield f"- Own set-up of the held-out run, from its first 30 %: {own}. All held-out figures are of the rest."
    vetoed = ", ".join(f"`{name}`" for name in found.vetoed) or "nothing"
    yield f"- Fitted, but lost on the held-out run and thrown out: {vetoed}."
    hidden = ", ".join(f"`{name}`" for name in found.not_excited) or "nothing"
    yield f"- Not even the strongest would have shown in these data: {hidden}."


def _files(names: Sequence[str]) -> str:
    return " and ".join(f"`{name}`" for name in names)


def _change(old: float, new: float) -> str:
    return f"{100.0 * (new / old - 1.0):+.0f} %" if old > 0.0 else "-"


if __name__ == "__main__":
    sys.exit(main())
