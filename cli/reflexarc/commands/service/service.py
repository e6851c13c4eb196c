"""`reflexarc service`: the loop as a service that systemd starts, watches and starts again."""

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import tyro

from reflexarc.terminal.output import console, print_json
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc.commands.drive.run import RunCommand
    from reflexarc_runtime.service.unit import ServiceUnit

SYSTEM_UNITS = Path("/etc/systemd/system")


@dataclass(frozen=True)
class ServiceCommand:
    """Run the loop as a service: install, remove or show the unit that systemd follows.

    The service runs `reflexarc run --config FILE` with as few rights as it needs, is ready after
    its first tick, is fed by its ticks, and is started again when it fails or hangs, later and
    later. A body of `--arm-each-runtime` stands after each such start until `reflexarc arm`. Flags
    that are wrong, or a policy that cannot be used, are said here, before anything is written.

    Examples:
      reflexarc service show /etc/reflexarc/robot0.toml
      reflexarc service install /etc/reflexarc/robot0.toml
      reflexarc service install robot0.toml --user robot --writes /var/log/robot
      reflexarc service remove /etc/reflexarc/robot0.toml
    """

    action: tyro.conf.Positional[Literal["install", "remove", "show"]]
    """What to do."""
    config: tyro.conf.Positional[Path]
    """The settings of `reflexarc run` (TOML); `reflexarc run … --show-config` prints one."""
    user: str = ""
    """Run as this user; by default, as one that systemd makes for it."""
    writes: tuple[Path, ...] = ()
    """Folders beside its own, /var/lib/reflexarc-<robot>, that it may write to."""
    watchdog_s: float = 1.0
    """Start it again when it has made no tick for so long."""
    units: Path = SYSTEM_UNITS
    """Folder of the units."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Install, remove or show the unit."""
        unit = self._unit()
        path = self.units / unit.name
        if self.action == "show":
            self._tell(unit, path, unit.text())
            return 0
        if self.action == "install":
            self._install(unit, path)
        else:
            self._remove(unit, path)
        return 0

    def _install(self, unit: "ServiceUnit", path: Path) -> None:
        from reflexarc.wiring.keeping_logs.service_places import check_places
        from reflexarc_runtime.files import write_atomically

        settings = self._settings()
        check_policy(settings)
        check_places(settings.record, settings.recording, settings.box, unit)
        if not self.units.is_dir():
            raise UsageError(f"--units: {self.units}: no such folder; is systemd installed here?")
        write_atomically(path, unit.text().encode())
        started = self._systemctl("daemon-reload") and self._systemctl("enable", unit.name)
        then = f"systemctl start {unit.name}"
        words = f"wrote {path}; next: {then if started else f'systemctl daemon-reload; {then}'}"
        self._tell(unit, path, words)

    def _remove(self, unit: "ServiceUnit", path: Path) -> None:
        if not path.exists():
            raise UsageError(f"{path}: no such unit; installed under another --units?")
        self._systemctl("disable", "--now", unit.name)
        path.unlink()
        self._systemctl("daemon-reload")
        self._tell(unit, path, f"removed {path}; its logs stay in /var/lib/{unit.folder}")

    def _unit(self) -> "ServiceUnit":
        from reflexarc_logs.recording.recorder import PATIENCE_S
        from reflexarc_runtime.service.unit import ServiceUnit

        settings = self._settings()
        config = str(self.config.absolute())
        return ServiceUnit(
            robot=settings.joining.robot,
            command=(sys.executable, "-m", "reflexarc", "run", "--config", config),
            watchdog_s=self.watchdog_s,
            stop_s=2 * PATIENCE_S + 5.0,  # of the whole run, and of a black box
            user=self.user,
            writes=self.writes,
            networked=settings.joining.zenoh is not None,
            realtime_priority=settings.punctuality.settings.highest_priority,
            systemd_version=systemd_version(),
        )

    def _settings(self) -> "RunCommand":
        from reflexarc.commands.drive.run import RunCommand
        from reflexarc.config_file.reading import settings_of

        settings = settings_of(RunCommand, self.config)
        if not isinstance(settings.policy, Path):
            raise UsageError(f"{self.config}: policy: missing; expected the path of a policy")
        if settings.lockstep:
            raise UsageError(f"{self.config}: lockstep: expected a service in real time")
        return settings

    def _systemctl(self, *words: str) -> bool:
        """Ask the manager, if it runs here and the unit is its own; whether it did."""
        if self.units != SYSTEM_UNITS or not Path("/run/systemd/system").is_dir():
            return False
        done = subprocess.run(["systemctl", *words], capture_output=True, text=True, check=False)
        if done.returncode:
            raise UsageError(f"systemctl {' '.join(words)}: {done.stderr.strip()[:200]}")
        return True

    def _tell(self, unit: "ServiceUnit", path: Path, words: str) -> None:
        if self.json:
            print_json({"unit": unit.name, "path": str(path), "text": unit.text()})
        elif self.action == "show":
            print(words, end="")
        else:
            console.print(words, soft_wrap=True)


def check_policy(settings: "RunCommand") -> None:
    """Try the policy as `run` would: a service that cannot start helps nobody.

    Raises:
        ReflexarcError: it cannot be used.
    """
    from reflexarc_runtime.policy.policy import load_policy

    load_policy(settings.policy, settings.backend, bounds=settings.bounds)


def systemd_version() -> int:
    """The version of the systemd on this machine; a new one where there is none."""
    from reflexarc_runtime.service.unit import BACK_OFF_SINCE

    try:
        done = subprocess.run(
            ["systemctl", "--version"], capture_output=True, text=True, check=False
        )
        return int(done.stdout.split()[1])
    except (OSError, ValueError, IndexError):
        return BACK_OFF_SINCE
