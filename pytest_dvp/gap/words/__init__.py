"""Sentences and pages about a comparison, a diagnosis and an extension. Begin with `comparison.py`."""
