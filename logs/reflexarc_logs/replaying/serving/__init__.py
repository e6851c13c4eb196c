"""Several policies on one log: who took over from whom, and who watched."""
