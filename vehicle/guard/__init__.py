"""What stands in front of a real car: it clamps or stops commands, whatever the stack does. Begin with `guard.py`."""
