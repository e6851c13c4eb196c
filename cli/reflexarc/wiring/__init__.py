"""Putting rooms together for a command: bus flags, recorders, several robots in a process."""
