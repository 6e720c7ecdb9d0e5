"""Drives under drawn names, units, signs and clocks, for what `dvp map` makes of the columns of a foreign log."""
