"""Adapters: cars that are reached over a wire, behind the Vehicle protocol."""
