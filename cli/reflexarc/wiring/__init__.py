"""Connects packages for a command: bus flags, recorders, several robots in one process."""
