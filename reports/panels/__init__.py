"""Panels of the page of a run, one file a panel, found by being here. Begin with `panel.py`."""
