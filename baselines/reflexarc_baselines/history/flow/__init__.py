"""Steering by optic flow: how fast things pass by on either side."""
