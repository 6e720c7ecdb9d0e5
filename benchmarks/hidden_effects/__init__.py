"""How well hidden effects are named: `python -m benchmarks.hidden_effects`. See `docs/hidden_effects.md`."""
