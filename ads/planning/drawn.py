"""Nets as plain data, for whoever draws them."""

from __future__ import annotations

from typing import Any

from ads.planning.petri_net import Net


def plain_net(net: Net) -> dict[str, Any]:
    """JSON-able data of a net; places in order, with what they do."""
    return {
        "name": net.name,
        "parent": net.parent,
        "initial": list(net.initial),
        "places": dict(net.actions),
        "transitions": [
            {
                "name": t.name,
                "take": list(t.take),
                "give": list(t.give),
                "when": list(t.when),
                "unless": list(t.unless),
            }
            for t in net.transitions
        ],
    }
