"""When the next input is likely to arrive: by the even times at which its sensor seems to send.

An alpha–beta filter (g–h filter) over the arrivals: it predicts the next one from a phase and an
interval, and moves both a little towards what came, so that one late arrival does not move the
next. How much sooner than expected one came is remembered, and forgotten slowly.

It is a guess, to do something before: nothing that a robot does depends on it.
"""

_PHASE_SHARE, _INTERVAL_SHARE = 4, 32
"""Of what an arrival was late, this part moves the phase, and the interval."""
_FORGETTING = 32
"""Arrivals in which what is remembered falls to 37 %."""


class ExpectedArrival:
    """Guesses the next arrival from those before."""

    def __init__(self) -> None:
        self._last_ns: int | None = None
        self._interval_ns = 0
        """0: nothing is known yet."""
        self._even_ns = 0
        """When the next one arrives if it comes evenly."""
        self._early_ns = 0
        """How much sooner than that inputs come."""

    def came(self, arrival_ns: int) -> None:
        """An input arrived."""
        late_ns = arrival_ns - self._even_ns
        if 2 * abs(late_ns) < self._interval_ns:
            self._early_ns = max(self._early_ns - self._early_ns // _FORGETTING, -late_ns)
            self._interval_ns += late_ns // _INTERVAL_SHARE
            self._even_ns += late_ns // _PHASE_SHARE + self._interval_ns
        elif self._last_ns is not None:  # one was lost, or the sensor begins anew
            self._interval_ns = arrival_ns - self._last_ns
            self._even_ns = arrival_ns + self._interval_ns
        self._last_ns = arrival_ns

    def next_ns(self) -> int | None:
        """Before the next arrival, but not long before; None: nothing is known of it.

        Where inputs come so unevenly that it would be long before, nothing is known either.
        """
        if 4 * self._early_ns >= self._interval_ns:
            return None
        return self._even_ns - self._early_ns
