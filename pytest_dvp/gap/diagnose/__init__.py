"""Which physical effect a model lacks, judged on held-out data. Begin with `diagnose.py`."""
