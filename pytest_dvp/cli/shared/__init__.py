"""What several commands share: options, printed commands, progress. Begin with `arguments.py`."""
