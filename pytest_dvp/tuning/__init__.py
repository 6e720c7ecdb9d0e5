"""Tuning of P and S, and the iteration over the stages that closes reality gap and performance gap (MCRPG)."""
