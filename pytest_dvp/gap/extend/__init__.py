"""A model file with the effects that a diagnosis found. Begin with `extend.py`."""
