"""The gap between a model and a measured car: compare, diagnose, extend, and manoeuvres that would tell more.

Begin with `compare/compare.py`, then `diagnose/diagnose.py`.
"""
