"""Gates: files that bound metrics, and the verdict on a log or between stages.

Begin with `judging.py`; `gate_file.py` reads a file of gates.
"""
