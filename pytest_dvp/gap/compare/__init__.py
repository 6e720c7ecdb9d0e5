"""How far a model is from a log, signal by signal and regime by regime. Begin with `compare.py`."""
