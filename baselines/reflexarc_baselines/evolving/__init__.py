"""Evolving the baselines whose sources evolved theirs: whole populations in one simulation."""
