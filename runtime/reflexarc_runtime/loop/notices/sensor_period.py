"""How often a sensor really sends, and whether a policy can live with it."""

from collections import deque
from statistics import median

from reflexarc_runtime.contract.contract import PolicyContract

_INTERVALS = 9
_ENOUGH = 4
"""Intervals from which a period is believed."""
_OFTEN = 3
"""So many of the last intervals are no accident: at each of them the robot stands."""
_SILENT = 5
"""A sensor that is silent for so many periods is not described by them."""


class SensorPeriod:
    """Measures the time between the inputs that ticks used."""

    def __init__(self) -> None:
        self._intervals_ns: deque[int] = deque(maxlen=_INTERVALS)
        self._last_ns: int | None = None

    def saw(self, received_ns: int) -> bool:
        """Take the arrival of the input that a tick used; whether it is another one."""
        last_ns, self._last_ns = self._last_ns, received_ns
        if last_ns is None or received_ns <= last_ns:
            return False
        self._intervals_ns.append(received_ns - last_ns)
        return True

    @property
    def period_ns(self) -> int | None:
        """The median of the last intervals; None before there are enough."""
        if len(self._intervals_ns) < _ENOUGH:
            return None
        return round(median(self._intervals_ns))

    @property
    def often_ns(self) -> int:
        """As long as this, or longer, are several of the last intervals."""
        longest = sorted(self._intervals_ns)[-_OFTEN:]
        return longest[0] if len(longest) == _OFTEN else 0

    def in_words(self, now_ns: int, sensor: str) -> str:
        """How often it sends; empty before that is known."""
        period_ns = self.period_ns
        if period_ns is None or self._last_ns is None:
            return ""
        silent_ns = now_ns - self._last_ns
        if silent_ns > _SILENT * period_ns:
            return f"no {sensor} for {silent_ns * 1e-9:.1f} s"
        return f"{sensor}s every {period_ns / 1e6:.0f} ms"


def misfit(period: SensorPeriod, contract: PolicyContract, sensor: str) -> str:
    """Why a sensor cannot serve a policy, in words; empty if it can.

    Args:
        period: of the sensor, known.
        contract: of the policy.
        sensor: what it sends: retina, scan.
    """
    oldest_ms, period_ms = contract.max_input_age_s * 1e3, (period.period_ns or 0) / 1e6
    often_ms = period.often_ns / 1e6
    if max(period_ms, often_ms) <= oldest_ms:
        return ""
    share = "most" if period_ms > oldest_ms else "part"
    often = f", and often {often_ms:.0f} ms" if share == "part" else ""
    return (
        f"{sensor}s every {period_ms:.0f} ms{often}, the policy takes inputs of at most "
        f"{oldest_ms:.0f} ms: it stands {share} of the time. Train one for this sensor (reflexarc "
        f"train --max-input-age {_advice_s(max(period_ms, often_ms)):g}), or let the sensor send "
        "more often"
    )


def _advice_s(period_ms: float) -> float:
    """Two periods and a half, so that one message may be lost, and jitter; in steps of 50 ms."""
    return -(-2.5 * period_ms // 50) * 0.05
