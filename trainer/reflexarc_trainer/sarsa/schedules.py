"""Schedules over a run. They count steps and never seconds, so that a run can be repeated.

The functions are plain Python; the compiled loops compile these same ones.
"""


def linear(step: float, start: float, end: float, span_steps: float) -> float:
    """A value that changes linearly from `start` to `end`, and then stays: ε, α, the learning rate.

    Args:
        step: now, 0 at the start.
        start: value at step 0.
        end: value from step `span_steps` on.
        span_steps: steps of the change.
    """
    if step >= span_steps:
        return end
    return start + (end - start) * (step / span_steps)
