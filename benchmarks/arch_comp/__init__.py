"""The vehicle problems of ARCH-COMP's falsification category, rebuilt, and our searchers on them.

Begin with `problems.py`: what is driven, and what is required. `python -m benchmarks.arch_comp` measures.
"""
