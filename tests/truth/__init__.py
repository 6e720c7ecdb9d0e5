"""Measured logs of cars whose hidden effects are known, made apart from the kernel that is to find them."""
