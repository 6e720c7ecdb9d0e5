"""Cars of another make: built of bodies, springs and tyres in MuJoCo, sharing nothing with the kernel.

`python -m benchmarks.foreign_cars` asks the diagnosis about them; begin with `car.py` and `drive.py`.
"""
