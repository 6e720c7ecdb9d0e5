"""What the gates say, the worst first."""

from __future__ import annotations

from typing import Any

from reports.panels.panel import Run
from reports.verdicts import STATUS_SIGNS

PLACE = 10  # on the page of a run, from the top


def values(run: Run) -> dict[str, Any]:
    """The rows of the table, and the sign of each status."""
    shown = [row for row in run.rows if not row.is_folded]
    return {"rows": shown, "folded": [row for row in run.rows if row.is_folded], "signs": STATUS_SIGNS}


TEMPLATE = """\
{% macro line(row) %}
    <tr class="{{ row.status | lower }}">
      {% include 'verdict.html' %}
      <td class="num" data-label="worst at">{% if row.t is not none %}<button class="jump" data-t="{{ row.t }}" data-object="{{ row.object }}">{{ "%.2f" | format(row.t) }} s</button>{% endif %}</td>
      <td data-label="object">{{ row.object }}</td>
      <td class="place" data-label="set in">{{ row.place }}</td>
    </tr>
    {% if row.message and row.status != "PASS" %}<tr class="message {{ row.status | lower }}"><td></td><td colspan="8">{{ row.message }}</td></tr>{% endif %}
{% endmacro %}
<section>
  <h2>Verdicts <small>worst first; click a time to see that moment</small></h2>
  <table class="verdicts stacked">
    <thead><tr><th></th><th>gate</th><th class="num">value</th><th class="num">must be</th>
      <th class="num">margin</th><th title="0 %: it could not be better; 100 %: at the bound">share of the bound used</th><th class="num">worst at</th><th>object</th><th>set in</th></tr></thead>
    <tbody>
    {% for row in rows %}
    {{ line(row) }}
    {% else %}
    <tr><td colspan="9">No gate was judged.</td></tr>
    {% endfor %}
    </tbody>
  </table>
  {% if folded %}<details><summary>{{ folded | length }} bounds that clean drives of this stack keep also hold; nearest: {{ folded[0].name }} {{ folded[0].value | short }} {{ folded[0].unit }} (must be {{ folded[0].limit }})</summary>
  <table class="verdicts stacked">
    <tbody>
    {% for row in folded %}
    {{ line(row) }}
    {% endfor %}
    </tbody>
  </table></details>{% endif %}
</section>
"""  # noqa: E501
