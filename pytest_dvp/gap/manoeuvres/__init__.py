"""Manoeuvres that a driver or a robot can drive to learn which effect a car has, and which of them is worth driving."""
