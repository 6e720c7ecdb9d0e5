"""Formats of logs, one file a format, found by being here; `FORMAT` declares it. Begin with `log_format.py`."""
