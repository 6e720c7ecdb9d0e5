"""The answers of `dvp diagnose` to logs of cars with hidden effects, as the tool gives them: docs/blind.md and .jsonl.

python -m scripts.blind_answers FOLDER      # FOLDER/case_NN/{rich,urban}.csv and FOLDER/model.toml
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1] / "docs"
HEAD = """# Blind cases

These are logs of a car with hidden effects; only their authors know the answers. For each log, this page shows the
unedited output of `dvp diagnose`. The complete documents are in [blind.jsonl](blind.jsonl). `make blind` writes both.
"""


def ask(case: Path, model: Path, *options: str) -> str:
    """What the command prints. Raises CalledProcessError if it fails."""
    logs = [str(case / "rich.csv"), str(case / "urban.csv")]
    command = [sys.executable, "-m", "pytest_dvp.cli", "diagnose", *logs, "--model", str(model), *options]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def main() -> int:
    """Ask all cases of a folder and write both files."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    text, lines = [HEAD], []
    for case in sorted(folder.glob("case_*")):
        print(case.name, file=sys.stderr)
        answer = ask(case, folder / "model.toml").replace(f"{folder}/", "")
        text.append(f"## {case.name}\n\n```\n{answer.rstrip()}\n```\n")
        document = json.loads(ask(case, folder / "model.toml", "--json"))
        lines.append(json.dumps({"case": case.name, **document}, ensure_ascii=False))
    (DOCS / "blind.md").write_text("\n".join(text), encoding="utf-8")
    (DOCS / "blind.jsonl").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
