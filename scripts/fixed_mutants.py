"""Five mutants that are judged in each `make test`, one of each folder:  python -m scripts.fixed_mutants

They show that the machinery works: a mutant takes effect, and its tests see it. Each is cheap.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from scripts.mutant_run import Checkout, run_tests, warm_up
from scripts.mutant_sample import ROOT, Mutant, mutants

FIXED = (
    ("pytest_dvp/gap/compare/iso18571.py", "NumberReplacer", "EPS_PHASE, K_PHASE = ", "unit/gap/test_iso18571.py"),
    ("pytest_dvp/metrics/task_outcome.py", "ReplaceComparisonOperator_IsNot_Is", "ends = ",
     "unit/results/test_metrics_task.py"),
    ("pytest_dvp/verdicts/judging.py", "AddNot", "missed = ", "unit/results/test_gates_nothing_happened.py"),
    ("openscenario/storyboard/speed_curve.py", "ReplaceBinaryOperator_Mul_Div", "self.jerk * after",
     "unit/storyboard/test_speed_curve.py"),
    ("vehicle/model/car.py", "ReplaceUnaryOperator_USub_UAdd", '"center_x"', "unit/vehicle/test_vehicle_parameters.py"),
)  # fmt: skip
"""Path, operator, text in the line, and the test file that judges: the first such mutant of the file."""
SECONDS = 60.0


def fixed(path: str, operator: str, text: str) -> Mutant:
    """The first mutant of the file by this operator in a line with this text. Raises LookupError if there is none."""
    source = (ROOT / path).read_text(encoding="utf-8")
    lines = source.splitlines()
    for mutant in mutants(path, source):
        if mutant.operator == operator and text in lines[mutant.line - 1]:
            return mutant
    raise LookupError(f"{path}: no {operator} in a line with {text!r}")


def main() -> int:
    """Judge the five, print a line for each; 1 if one survives."""
    warm_up()
    alive = 0
    with tempfile.TemporaryDirectory() as folder:
        checkout = Checkout(Path(folder))
        for path, operator, text, test in FIXED:
            mutant = fixed(path, operator, text)
            with checkout.changed(mutant):
                verdict, by = run_tests(checkout.place, [f"tests/{test}"], seconds=SECONDS)
            print(f"{verdict}: {mutant.name} {by}", flush=True)
            alive += verdict == "survived"
    return 1 if alive else 0


if __name__ == "__main__":
    sys.exit(main())
