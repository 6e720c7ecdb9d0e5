"""After a run: what never happened although the scenario provides for it, and why."""

from __future__ import annotations

from openscenario.findings import Finding
from openscenario.storyboard.nodes import RUNNING, Node


def report(root: Node) -> tuple[Finding, ...]:
    """Findings (warnings) about events that never fired, edges true from the start, acts that never ended."""
    found: list[Finding] = []
    stack = [root]
    while stack:
        node = stack.pop(0)
        stack[:0] = node.children
        if node.kind == "event" and node.executions == 0:
            found.append(_finding(node, "event-never-fired", f"event {node.name!r} never fired", _reason(node)))
        if node.kind == "act" and node.executions == 0:
            found.append(_finding(node, "act-never-started", f"act {node.name!r} never started", _reason(node)))
        if node.kind == "act" and node.state == RUNNING and _has_events(node):
            found.append(_finding(node, "act-never-ended", f"act {node.name!r} was still running at the end", ""))
        found.extend(_blind_edges(node))
    return tuple(found)


def _has_events(node: Node) -> bool:
    """Whether anything could have ended at all."""
    return node.kind == "event" or any(_has_events(child) for child in node.children)


def _blind_edges(node: Node) -> list[Finding]:
    """Conditions with an edge that were true at their first evaluation, where no edge can be seen."""
    found: list[Finding] = []
    if node.executions > 0 or node.start is None:
        return found
    for group in node.start.groups:
        for state in group:
            if state.true_at_start:
                at = state.model.at
                found.append(
                    Finding(
                        code="edge-true-from-start",
                        severity="warning",
                        file=at.file,
                        line=at.line or None,
                        element=at.element,
                        text=f"condition {state.model.name!r} was true from its first evaluation on",
                        found=f"conditionEdge {state.model.condition_edge}",
                        hint="an edge needs the condition to be false before; conditionEdge 'none' fires at once",
                    )
                )
    return found


def _reason(node: Node) -> str:
    parent = node.parent
    if parent is not None and parent.executions == 0 and parent.kind != "storyboard":
        return f"its {parent.kind} {parent.name!r} never started"
    if node.start is None:
        return ""
    never = [
        state.model.name or type(state.model.condition).__name__
        for group in node.start.groups
        for state in group
        if not state.ever
    ]
    if never:
        return "never true: " + ", ".join(repr(name) for name in never)
    return "its conditions were never true at the same time"


def _finding(node: Node, code: str, text: str, hint: str) -> Finding:
    at = node.at
    return Finding(
        code=code,
        severity="warning",
        file=at.file,
        line=at.line or None,
        element=at.element or "/".join(node.path),
        text=text,
        hint=hint,
    )
