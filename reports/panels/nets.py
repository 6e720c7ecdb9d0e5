"""The decision nets of the stack."""

from __future__ import annotations

from typing import Any

from reports.panels.panel import Run

PLACE = 40  # on the page of a run, from the top


def values(run: Run) -> dict[str, Any] | None:
    """The drawings of the nets; None for a stack without any."""
    return {"nets": run.nets} if run.nets else None


TEMPLATE = """\
<section>
  <h2>Decision nets <small>Petri nets of the stack; a filled place is active at the time shown above, the number is its share of the run</small></h2>
  <div class="nets">
  {% for net in nets %}
  <figure>
    <figcaption>{{ net.name }}{% if net.parent %}<small>runs while {{ net.parent | replace(".", " is in ") }}</small>{% endif %}</figcaption>
    <svg viewBox="0 0 {{ net.width }} {{ net.height }}" role="img" aria-label="Petri net {{ net.name }}">
      <defs><marker id="head{{ loop.index }}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto"><path class="head" d="M0 0L8 4L0 8z"/></marker></defs>
      {% set head = loop.index %}{% for bar in net.bars %}
      <g>{% for arc, arrow in bar.arcs %}<path d="{{ arc }}"{% if arrow %} marker-end="url(#head{{ head }})"{% endif %}/>{% endfor %}<line class="bar" x1="{{ bar.x }}" x2="{{ bar.x }}" y1="{{ bar.y - 9 }}" y2="{{ bar.y + 9 }}"/>
        <text x="{{ bar.text_x }}" y="{{ bar.y - 3 if bar.guard else bar.y + 4 }}" text-anchor="{{ bar.anchor }}">{{ bar.name | replace("_", " ") }}</text>{% for line in bar.guard %}<text class="guard" x="{{ bar.text_x }}" y="{{ bar.y + 9 + 12 * loop.index0 }}" text-anchor="{{ bar.anchor }}">{{ line }}</text>{% endfor %}</g>
      {% endfor %}{% for place in net.places %}
      <g class="{{ 'used' if place.share else '' }}" data-net="{{ net.name }}" data-place="{{ place.name }}"><title>{{ place.name }}: {{ place.action }}</title>
        <circle class="place" cx="{{ net.width / 2 }}" cy="{{ place.y }}" r="30"/>{% if place.initial %}<circle class="initial" cx="{{ net.width / 2 }}" cy="{{ place.y - 18 }}" r="3"/>{% endif %}
        <text x="{{ net.width / 2 }}" y="{{ place.y + 3 }}" text-anchor="middle">{{ place.name }}</text>{% if place.share is not none %}<text class="share" x="{{ net.width / 2 }}" y="{{ place.y + 15 }}" text-anchor="middle">{{ "%.0f" | format(place.share * 100) }} %</text>{% endif %}</g>
      {% endfor %}
    </svg>
  </figure>
  {% endfor %}
  </div>
</section>
"""  # noqa: E501
