"""Simulations in other processes and on other machines, and the cache of their results. Begin with `pool.py`."""
