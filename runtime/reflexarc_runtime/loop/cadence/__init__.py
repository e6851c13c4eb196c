"""How punctual a loop is, phase by phase: histograms, percentiles, counts."""
