"""Worlds as data: layers, shapes, seeds and the TOML files that describe them. Nothing compiled."""
