"""The flags of a runtime's sense."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from reflexarc.wiring.scan_flags import ScanFlags

if TYPE_CHECKING:
    from reflexarc_runtime.sensing.sense_settings import SenseSettings


@dataclass(frozen=True)
class SenseFlags:
    """How to read what the sensors send."""

    allow_unstated_eye: bool = False
    """Take retinas that do not say which eye made them."""
    frozen_after: float | None = None
    """Refuse inputs that never change for so many seconds while the body is told to drive: their
    driver hangs."""
    least_returns: float | None = None
    """Refuse scans of which fewer beams, as a share, have a return: the scanner is covered, or
    broken."""
    scanner: ScanFlags = field(default_factory=ScanFlags)

    @property
    def settings(self) -> "SenseSettings":
        """The settings of the sense.

        Raises:
            UsageError: a flag is out of range.
        """
        from reflexarc_runtime.sensing.sense_settings import SenseSettings

        scanner = self.scanner
        return SenseSettings(
            self.allow_unstated_eye,
            scanner.known_mount,
            scanner.ignored,
            scanner.meaning,
            self.frozen_after,
            self.least_returns,
        )
