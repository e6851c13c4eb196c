"""The simulation: one compiled step for many agents, and its face in Python."""
