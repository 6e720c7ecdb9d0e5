"""Text that nearly every room writes: paths, JSON without NaN, numbers, the nearest name. Begin with `paths.py`."""
