"""Whether a bridge has fallen silent, so that its companion has to tell the robot to stand.

A bridge that lives speaks once a period, whatever happens. If two periods pass without a twist of
its own it is dead, stopped or stuck, and a robot that holds its last twist goes on with it. From
then on the companion says standstill, until 2 s after the last twist that moved the robot; then it
is silent, so that a person can drive the robot away. A robot that has been told to stand for so
long needs nobody's word. Where its odometry says that it stands, that is enough, after half a
second: one that lies, or says nothing, makes it no shorter than that and no longer than 2 s.
"""

from dataclasses import dataclass, replace

HELD_NS = 2_000_000_000
"""How long after the last twist that moved it a robot is told to stand."""
LEAST_NS = 500_000_000
"""How long in any case, whatever its odometry says."""
PERIODS = 2
"""So many periods without a twist are a silence: one twist may be late, or lost."""


@dataclass(frozen=True, slots=True)
class BridgeSilence:
    """What was heard of a bridge."""

    period_ns: int
    """The bridge's."""
    heard_ns: int | None = None
    """When its last twist came; None: none yet."""
    moved_ns: int | None = None
    """When the last one came that was no standstill."""

    def heard(self, now_ns: int, moves: bool) -> "BridgeSilence":
        """What is known after another twist of the bridge."""
        return replace(self, heard_ns=now_ns, moved_ns=now_ns if moves else self.moved_ns)

    def must_speak(self, now_ns: int, is_gone: bool) -> bool:
        """Whether the robot has to be told to stand now.

        Args:
            now_ns: the time.
            is_gone: whether the bridge is known to have ended without a farewell.
        """
        if self.heard_ns is None or self.moved_ns is None or now_ns - self.moved_ns >= HELD_NS:
            return False
        return is_gone or now_ns - self.heard_ns >= PERIODS * self.period_ns

    def stood(self, now_ns: int) -> "BridgeSilence":
        """What is known when its odometry says that it stands, after it was told to.

        Then it needs no word until the bridge moves it again, also if it moves: a person drives it.
        """
        is_early = self.moved_ns is not None and now_ns - self.moved_ns < LEAST_NS
        return self if is_early else replace(self, moved_ns=None)

    def look_ns(self, now_ns: int) -> int:
        """When to look again: when the next silence would begin; in one already, in a period."""
        if self.heard_ns is not None:
            silent_ns = self.heard_ns + PERIODS * self.period_ns
            if silent_ns > now_ns:  # not a period later: that would be a third one in silence
                return silent_ns
        return now_ns + self.period_ns
