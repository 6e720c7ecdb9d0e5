"""Metrics that no gate looks at: they are shown, not judged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from reports.panels.panel import Run
from reports.verdicts import Row

PLACE = 30  # on the page of a run, from the top


def values(run: Run) -> dict[str, Any] | None:
    """The rows of the table; None where every metric has a gate."""
    metrics = _metric_rows(run.result.get("metrics", {}), run.rows)
    return {"metrics": metrics} if metrics else None


def _metric_rows(metrics: Mapping[str, Mapping[str, Any]], table: Sequence[Row]) -> list[dict[str, Any]]:
    """Metrics that no gate looks at: they are shown, not judged."""
    gated = {row.metric for row in table}
    return [{"name": name, **value} for name, value in sorted(metrics.items()) if name not in gated]


TEMPLATE = """\
<section>
  <h2>Other metrics <small>measured, not judged</small></h2>
  <table class="metrics"><tbody>
  {% for metric in metrics %}
    <tr><td><b>{{ metric.name }}</b></td>
      <td class="num">{% if metric.valid %}{{ metric.value | short }}{% else %}not measured{% endif %}{% if metric.unit | unit %} <span class="unit">{{ metric.unit | unit }}</span>{% endif %}</td>
      <td class="num">{% if metric.valid and metric.t is number %}<button class="jump" data-t="{{ metric.t }}" data-object="{{ metric.object or '' }}">{{ "%.2f" | format(metric.t) }} s</button>{% endif %}</td>
      <td>{{ metric.object or "" }}{% if not metric.valid %}{{ metric.reason | default("") }}{% endif %}</td></tr>
  {% endfor %}
  </tbody></table>
</section>
"""  # noqa: E501
