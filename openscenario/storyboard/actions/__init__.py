"""Actions, one file a family; found through `registry.action`."""
