"""Searchers: each asks for points and is told how good they were. Begin with `search.py`."""
