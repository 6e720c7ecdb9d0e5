"""Hidden laws for `dvp discover`: drawn by seed, written apart from its grammar."""
