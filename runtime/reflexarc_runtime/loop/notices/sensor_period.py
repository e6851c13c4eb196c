"""How often a sensor really sends, and whether a policy can live with it."""

from collections import deque
from statistics import median

from reflexarc_runtime.contract.contract import PolicyContract

_INTERVALS = 9
_ENOUGH = 4
"""Intervals from which a period is believed."""


class SensorPeriod:
    """Measures the time between the inputs that ticks used."""

    def __init__(self) -> None:
        self._intervals_ns: deque[int] = deque(maxlen=_INTERVALS)
        self._last_ns: int | None = None

    def saw(self, received_ns: int) -> None:
        """Take the arrival of the input that a tick used; the same one again is no new one."""
        if self._last_ns is not None and received_ns > self._last_ns:
            self._intervals_ns.append(received_ns - self._last_ns)
        self._last_ns = received_ns

    @property
    def period_ns(self) -> int | None:
        """The median of the last intervals; None before there are enough."""
        if len(self._intervals_ns) < _ENOUGH:
            return None
        return round(median(self._intervals_ns))


def misfit(period_ns: int, contract: PolicyContract, sensor: str) -> str:
    """Why a sensor of that period cannot serve a policy, in words; empty if it can.

    Args:
        period_ns: of the sensor.
        contract: of the policy.
        sensor: what it sends: retina, scan.
    """
    oldest_ms, period_ms = contract.max_input_age_s * 1e3, period_ns / 1e6
    if period_ms <= oldest_ms:
        return ""
    return (
        f"{sensor}s every {period_ms:.0f} ms, the policy takes inputs of at most {oldest_ms:.0f} "
        "ms: it stands most of the time. Train one for this sensor (reflexarc train "
        f"--max-input-age {_advice_s(period_ms):g}), or let the sensor send more often"
    )


def _advice_s(period_ms: float) -> float:
    """Twice the period, so that one message may be lost; in steps of 50 ms."""
    return -(-2 * period_ms // 50) * 0.05
