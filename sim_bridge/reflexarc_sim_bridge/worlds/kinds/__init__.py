"""The kinds of layers as data, one module a kind; `layers.py` lists them all."""
