"""A torch module written as the ONNX graph of a policy, call by call."""
