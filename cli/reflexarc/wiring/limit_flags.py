"""The flags by which a robot's owner says what it does at most, whatever it is told."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_runtime.contract.body_limits import BodyLimits


@dataclass(frozen=True)
class LimitFlags:
    """The largest speeds of a robot. All three have to be said, by flags or by a file."""

    max_linear: float | None = None
    """Largest speed ahead and back, metres a second."""
    max_lateral: float | None = None
    """Largest speed to the side, metres a second; 0 for a robot that cannot go sideways."""
    max_angular: float | None = None
    """Largest angular speed, radians a second."""
    max_acceleration: float | None = None
    """Most that a speed grows in a second, m/s²; it never delays a stop."""
    max_validity: float | None = None
    """Longest time for which a command is obeyed, seconds, whatever it says itself."""
    limits: Path | None = None
    """TOML file with the same as [limits]; where a flag says less, the flag counts."""

    def body_limits(self) -> "BodyLimits":
        """What the robot does at most.

        Raises:
            UsageError: a number that is none, or a speed that nothing limits.
        """
        limits = self._of_file().narrowed(self._of_flags())
        for flag, value in (
            ("--max-linear", limits.linear_mps),
            ("--max-lateral", limits.lateral_mps),
            ("--max-angular", limits.angular_radps),
        ):
            if not math.isfinite(value):
                raise UsageError(
                    f"ros2: expected the robot's largest speeds (--max-linear, --max-lateral, "
                    f"--max-angular, or --limits FILE), got no {flag}"
                )
        return limits

    def _of_flags(self) -> "BodyLimits":
        from reflexarc_runtime.contract.body_limits import BodyLimits

        return BodyLimits(
            linear_mps=_value("--max-linear", self.max_linear),
            lateral_mps=_value("--max-lateral", self.max_lateral),
            angular_radps=_value("--max-angular", self.max_angular),
            acceleration_mps2=_value("--max-acceleration", self.max_acceleration, can_be_0=False),
            valid_for_s=_value("--max-validity", self.max_validity, can_be_0=False),
        )

    def _of_file(self) -> "BodyLimits":
        from reflexarc_runtime.config.fill import fill
        from reflexarc_runtime.config.toml_source import TomlSource, read_text
        from reflexarc_runtime.contract.body_limits import BodyLimits

        @dataclass(frozen=True)
        class _File:
            limits: BodyLimits

        if self.limits is None:
            return BodyLimits()
        name = str(self.limits)
        return fill(_File, TomlSource(read_text(self.limits, name), name)).limits


def _value(flag: str, value: float | None, *, can_be_0: bool = True) -> float:
    """The value of a flag, infinite where it was not given."""
    if value is None:
        return math.inf
    wanted = "0 or more, and finite" if can_be_0 else "above 0, and finite"
    fits = math.isfinite(value) and (value > 0.0 or (can_be_0 and value == 0.0))
    require(fits, flag, wanted, value)
    return value
