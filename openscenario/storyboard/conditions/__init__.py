"""Conditions, one file a family; found through `registry.condition`."""
