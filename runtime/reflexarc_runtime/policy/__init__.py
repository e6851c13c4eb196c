"""The policy file: loading and checking it, and the two backends that compute its graph."""
