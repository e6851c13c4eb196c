"""Anyone's node: a Python class that is fed from a log, and must say what was recorded."""
