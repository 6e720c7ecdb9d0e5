"""A car with other physics than the kernel: the truth that stands in for a real one. Nobody imports it."""
