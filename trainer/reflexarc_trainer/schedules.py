"""Schedules, in steps: they count transitions and never seconds, so that a run can be repeated.

The functions on single numbers are plain Python; the compiled loop compiles these same ones.
"""


def linear_epsilon(step: int, start: float, end: float, decay_steps: float) -> float:
    """ε at a step: from `start` at step 0 straight to `end` at `decay_steps`, then constant."""
    if step >= decay_steps:
        return end
    return start + (end - start) * (step / decay_steps)
