"""Measured speed beside a peer, in one run: `make bench` writes docs/benchmarks.md."""
