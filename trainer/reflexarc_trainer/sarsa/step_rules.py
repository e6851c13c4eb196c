"""Constants of the step rules, shared by the compiled forms and the reference."""

SQUARES_KEPT = 0.999
"""What the running means of squares keep at each step."""


LARGEST_TD_ERROR = 20.0
"""In multiples of its running RMS (arXiv 2604.19033)."""


SCALED_EVERY, SCALED_AT_FIRST = 16, 64
"""The step by RMS takes its scales anew at every so many-th update, and at each of the first ones.
"""


LARGEST_RATIO = 100.0
"""In multiples of a weight's running RMS. At 10 it learns to 2.4 contacts per 100 m in 800,000
transitions, at 30 to 2.2, at 100 and 300 to 2.1 and 2.2 (validation worlds, three to eight seeds).
"""


LEAST_RMS = 1e-8


LEAST_TOTAL = 1e-12
"""A trace whose Σ s e² is no more moves nothing: the intentional step, of which that is the
divisor, has no bound. Where units saturate it would end in numbers that are none.
"""
