"""The network in torch, and as a policy file: ONNX graph, export, parity check, warm start."""
