"""What the run was made of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from reports.panels.panel import Run

PLACE = 50  # on the page of a run, from the top

_TOO_LONG = {("model", "toml")}  # conditions that are whole files


def values(run: Run) -> dict[str, Any]:
    """Headings and rows."""
    return {"conditions": conditions(run.meta)}


def conditions(meta: Mapping[str, Any]) -> list[tuple[str, list[tuple[str, str]]]]:
    """(heading, rows) of what the run was made of, in reading order; what has no group of its own comes last."""
    single: list[tuple[str, str]] = []
    groups: list[tuple[str, list[tuple[str, str]]]] = []
    names = {"parameters": "Scenario parameters", "P": "ADS parameters (P)", "S": "Simulator parameters (S)",
             "task": "Task", "ego": "Ego", "versions": "Versions", "model": "Vehicle model",
             "timing": "Real time [s]"}  # fmt: skip
    shown = [key for key in meta if key not in ("nets", *names)]  # the nets are drawn
    for key in [*(key for key in names if key in meta), *shown]:
        value = meta[key]
        if isinstance(value, Mapping):
            entries = [(str(name), _text(entry)) for name, entry in value.items() if (key, name) not in _TOO_LONG]
            groups.append((names.get(key, key), entries or [("all at their defaults", "")]))
        else:
            single.append((names.get(key, key), _text(value)))
    return [("Run", single), *groups] if single else groups


def _text(value: Any) -> str:
    if value is None or value in ("", (), []):
        return "–"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_text(entry)}" for key, entry in value.items())
    if isinstance(value, (list, tuple)):
        return ", ".join(_text(entry) for entry in value)
    return str(value)


TEMPLATE = """\
<section>
  <h2>Conditions <small>what this run was made of</small></h2>
  <div class="conditions">
  {% for heading, entries in conditions %}
    <details{% if loop.index <= 2 or entries | length <= 8 %} open{% endif %}><summary>{{ heading }}</summary>
      <table>{% for name, value in entries %}<tr><td>{{ name }}</td><td>{{ value }}</td></tr>{% endfor %}</table>
    </details>
  {% endfor %}
  </div>
</section>
"""
