"""Road, air, wind and light of a run, from when on."""

from __future__ import annotations

from typing import Any

from reports.panels.panel import Run

PLACE = 45  # on the page of a run, from the top
KIND = "environment"  # of the events that tell it


def values(run: Run) -> dict[str, Any] | None:
    """Time [s], who changed it, and what holds from then on; None where nothing was said of it."""
    changes = [(event["t"], event["element"], event["text"]) for event in run.events if event["kind"] == KIND]
    return {"changes": changes} if changes else None


TEMPLATE = """\
<section>
  <h2>Weather and road <small>what limits tyres and sensors, from when on</small></h2>
  <table>
    <tr><th>from</th><th>environment</th><th>holds</th></tr>
    {% for t, name, text in changes %}
    <tr><td><button class="jump" data-t="{{ t }}" data-object="">{{ "%.2f" | format(t) }} s</button></td>
      <td>{{ name }}</td><td>{{ text }}</td></tr>
    {% endfor %}
  </table>
</section>
"""
