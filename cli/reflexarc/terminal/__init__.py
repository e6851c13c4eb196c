"""The terminal: tables, progress, keys, signals."""
