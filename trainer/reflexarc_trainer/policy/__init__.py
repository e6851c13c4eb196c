"""The learned network as a file: torch module, ONNX graph, export, parity check, warm start."""
