"""Schedules, in steps: they count transitions and never seconds, so that a run can be repeated.

The functions on single numbers are plain Python; the compiled loops compile these same ones.
"""


def linear(step: float, start: float, end: float, span_steps: float) -> float:
    """From `start` at step 0 straight to `end` at `span_steps`, then constant: ε, step sizes."""
    if step >= span_steps:
        return end
    return start + (end - start) * (step / span_steps)
