"""The ONNX operators of the NumPy backend, each a function of arrays."""
