"""One run: a scenario, a stack and a vehicle become a log and a result.

Begin with `run.py`; the options of a run are in `run_spec.py`, the loop itself in `loop.py`.
"""
