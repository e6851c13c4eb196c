"""Times of a world in its steps: whatever a step lasts, a world's name stands for one physics.

With a step of Δt a time T is T / Δt steps. Slip is a share σ of every speed, told for an averaging
time τ. A step's displacement v Δt is off by the share s, drawn anew each step, so that the variance
after T is (T / Δt) (v Δt s)²; with s = σ √(τ / Δt) it is v² σ² τ T for every Δt.
"""

import math

from reflexarc_sim_bridge.worlds.checks import require

MAX_LATENCY_STEPS = 1024
"""A second at the fastest rate of a body on the bus; every agent keeps so many retinas."""
MAX_GAP_STEPS = 1_000_000
"""Nothing is kept for a gap; so long is any gap that a world may have, at the fastest rate."""
MAX_STEP_S = 10.0

SLACK = 1e-9
"""Times and durations of steps are decimal fractions, whose ratio is rounded."""


def latency_steps(latency_s: float, dt_s: float) -> int:
    """The nearest whole number of steps; never none where there is a latency."""
    return max(round(latency_s / dt_s), 1) if latency_s > 0.0 else 0


def gap_steps(gap_s: float, dt_s: float) -> int:
    """Most whole steps within a gap, at least one: a sensor sends no later than it may."""
    return max(math.floor(gap_s / dt_s + SLACK), 1)


def slip_per_step(slip: float, over_s: float, dt_s: float) -> float:
    """Standard deviation of the speeds of one step, as a share of them."""
    return slip * math.sqrt(over_s / dt_s)


def require_duration(where: str, time_s: float) -> None:
    """Refuse what no step can last.

    Raises:
        WorldError: it cannot.
    """
    require(0.0 < time_s <= MAX_STEP_S, where, f"in (0, {MAX_STEP_S:g}] s", time_s)


def require_latency(latency_s: float, dt_s: float) -> None:
    """Refuse a latency of more steps than are kept.

    Raises:
        WorldError: it is longer.
    """
    _require_steps("senses.latency_s", latency_s, dt_s, MAX_LATENCY_STEPS)


def require_gap(gap_s: float, dt_s: float) -> None:
    """Refuse a gap of more steps than are counted.

    Raises:
        WorldError: it is longer.
    """
    _require_steps("senses.gap_s", gap_s, dt_s, MAX_GAP_STEPS)


def _require_steps(where: str, time_s: float, dt_s: float, most: int) -> None:
    expected = f"at most {most * dt_s:g} s, {most} steps of {dt_s:g} s"
    require(time_s / dt_s < most + 0.5, where, expected, time_s)
