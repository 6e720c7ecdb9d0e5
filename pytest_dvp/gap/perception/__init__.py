"""Which perception effect a twin lacks: detections against the truth. Begin with `diagnose_perception.py`."""
