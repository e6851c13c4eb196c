"""Baselines as policy files: NumPy code run once on stand-ins that write down its ONNX graph."""
