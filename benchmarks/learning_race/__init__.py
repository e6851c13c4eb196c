"""The modules of `benchmarks/learning.py`."""
