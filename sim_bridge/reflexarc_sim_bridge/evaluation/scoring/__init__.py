"""From sums over worlds to scores, intervals and verdicts."""
