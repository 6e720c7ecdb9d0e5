"""Many runs of one scenario: which sets of parameter values there are. Begin with `cases.py`."""
