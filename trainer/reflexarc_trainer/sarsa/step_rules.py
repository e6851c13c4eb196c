"""Constants of the step rules, shared by the compiled `online/traces.py` and `reference.py`.

Both files give the equations.
"""

SQUARES_KEPT = 0.999
"""Share of itself that a running mean of squares keeps at each update."""

LARGEST_TD_ERROR = 20.0
"""Intentional step: the largest |δ|, as a multiple of its running RMS (arXiv 2604.19033)."""

LEAST_TOTAL = 1e-12
"""Intentional step: no weight moves where Σ s e², its divisor, is not larger than this. The step
has no bound of its own, and where units saturate the divisor vanishes: weights would become NaN."""

SCALED_EVERY, SCALED_AT_FIRST = 16, 64
"""Step by RMS: the scales are recomputed at every 16th update, and at each of the first 64."""

LARGEST_RATIO = 100.0
"""Step by RMS: the largest |δe|, as a multiple of its running RMS. Contacts per 100 m after 800,000
transitions, on validation worlds, three to eight seeds: 2.4 at 10, 2.2 at 30, 2.1 at 100, 2.2 at
300."""

LEAST_RMS = 1e-8
"""Step by RMS: added to the RMS before the division, as usual for RMSProp."""
