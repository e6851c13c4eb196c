"""How far float32 may lie from the exact value, for the weights of one network."""
