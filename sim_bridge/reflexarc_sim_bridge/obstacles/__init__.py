"""Obstacles drawn from seeds, chunk by chunk, and the lists of those near an agent."""
