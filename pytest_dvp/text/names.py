"""Names that several rooms must spell alike."""

from __future__ import annotations

REFERENCE = "reference"  # the driving stack that ships
