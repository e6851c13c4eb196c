"""The commands, one module each, in the groups that the help shows."""
