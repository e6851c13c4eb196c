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
            self.allow_unstated_eye, scanner.known_mount, scanner.ignored, scanner.meaning
        )
