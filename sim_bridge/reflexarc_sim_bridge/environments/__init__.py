"""Gymnasium environments of the simulated worlds, for one agent and for many."""
