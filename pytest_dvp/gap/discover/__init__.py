"""Looks for a law that no catalogue has in what a model leaves unexplained. Begin with `discover.py`."""
