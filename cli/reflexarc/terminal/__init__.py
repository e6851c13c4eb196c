"""The terminal: tables, descriptions, progress, keys, signals."""
