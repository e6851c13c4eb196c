"""The flags of the guard, and the guard that they make for a policy."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:  # a command line shall not load a contract to show its flags
    from reflexarc_runtime.contract.contract import PolicyContract
    from reflexarc_runtime.guard import Guard
    from reflexarc_runtime.guard_settings import GuardSettings

ON, OFF = "on", "off: --no-guard"
"""What the status topic says."""
MOST_M = 100.0
"""A body with a larger radius is a mistake."""


@dataclass(frozen=True)
class GuardFlags:
    """Whether the guard is on, and what it takes for granted about the body."""

    no_guard: bool = False
    """Leave the guard out: the policy's word alone counts."""
    guard_margin_m: float = 0.05
    """Distance that the guard keeps from everything."""
    guard_radius_m: float | None = None
    """Radius of the body; by default the outline in the policy's contract."""
    guard_delay_s: float | None = None
    """From a command's arrival to its motion; by default the contract's."""
    guard_deceleration_mps2: float | None = None
    """How hard the body brakes; by default as the contract says."""
    guard_evade_s: float = 0.3
    """How much earlier it takes another action that is free."""
    guard_only_stops: bool = False
    """Never go slower than the policy wants: a motion of the policy's, or standstill."""
    guard_ranges: Literal["", "scan"] = ""
    """Topic of a range sensor or a bumper beside what the policy sees; by default none."""
    guard_ranges_oldest_s: float = 0.25
    """How old its ranges may be; without younger ones the robot stands."""

    def check(self, sensor: str, *, lockstep: bool) -> None:
        """Refuse ranges of a topic of their own where there can be none.

        Raises:
            UsageError: why.
        """
        if not self.guard_ranges:
            return
        if self.no_guard:
            raise UsageError("--guard-ranges: nobody looks at them with --no-guard")
        if self.guard_ranges == sensor:
            raise UsageError("--guard-ranges scan: the input is the scan already; leave it out")
        if lockstep:
            raise UsageError("--guard-ranges: not in lockstep, where every input is a tick")

    @property
    def state(self) -> str:
        """What the status topic says."""
        return OFF if self.no_guard else ON

    def settings_for(self, contract: "PolicyContract") -> "GuardSettings | None":
        """The settings of the guard; None without one.

        Raises:
            UsageError: a flag is out of range.
        """
        from reflexarc_runtime.contract.body_spec import Footprint
        from reflexarc_runtime.guard_settings import GuardSettings

        if self.no_guard:
            return None
        radius_m = self.guard_radius_m
        if radius_m is not None and not 0.0 <= radius_m <= MOST_M:
            raise UsageError(f"--guard-radius-m: expected 0 to {MOST_M:g}, got {radius_m}")
        given = {
            "margin_m": self.guard_margin_m,
            "footprint": None if radius_m is None else Footprint(radius_m),
            "delay_s": self.guard_delay_s,
            "deceleration_mps2": self.guard_deceleration_mps2,
            "evade_s": self.guard_evade_s,
            "may_slow": not self.guard_only_stops,
            "ranges": self.guard_ranges,
            "ranges_oldest_s": self.guard_ranges_oldest_s,
        }
        known = {name: value for name, value in given.items() if value is not None}
        return replace(GuardSettings.of(contract), **known)  # type: ignore[arg-type]  # each its own

    def guard_for(self, contract: "PolicyContract") -> "Guard | None":
        """The guard of a policy; None without one.

        Raises:
            UsageError: a flag is out of range.
        """
        from reflexarc_runtime.guard import Guard

        settings = self.settings_for(contract)
        return None if settings is None else Guard.for_contract(settings, contract)
