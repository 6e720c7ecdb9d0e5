"""Everything that only pytest needs: hooks, collection, fixtures, summaries. Begin with `hooks.py`."""

pytest_plugins = ["pytest_dvp.plugin.hooks"]
