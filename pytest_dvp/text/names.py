"""Names that several rooms must spell alike."""

from __future__ import annotations

REFERENCE = "reference"  # the driving stack that ships


NOT_ASKED = "NOT ASKED"  # of a gate that did not pass and that the test left out
