"""Hooks of the pytest plugin; imports the standard library and pytest only."""
