"""Puts faults between car and stack, and tells which of them the gates would not notice. Begin with `mutate.py`."""
