"""`reflexarc service`: the loop as a service that systemd starts, watches and starts again."""

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import tyro

from reflexarc.terminal.output import console, print_json
from reflexarc_runtime.config.checks import require
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.service.systemctl import systemctl, systemd_version

if TYPE_CHECKING:
    from reflexarc.commands.drive.run import RunCommand
    from reflexarc_runtime.service.unit import ServiceUnit

SYSTEM_UNITS = Path("/etc/systemd/system")
LEAST_WATCHDOG_S = 1.0


@dataclass(frozen=True)
class ServiceCommand:
    """Run the loop as a service: install, remove or show the unit that systemd follows.

    The service runs `reflexarc run --config FILE` with as few rights as it needs, is ready after
    its first tick, is fed by its ticks, and is started again when it fails or hangs, later and
    later. A body of `--arm-each-runtime` stands after each such start until `reflexarc arm`.
    Whatever `run` would refuse, or its user could not read, is said here, before anything is
    written; the Zenoh configuration systemd hands over (LoadCredential), whoever may read the file.

    Examples:
      reflexarc service show /etc/reflexarc/robot0.toml
      reflexarc service install /etc/reflexarc/robot0.toml
      reflexarc service install robot0.toml --user robot --writes /var/log/robot
      reflexarc service remove robot0
    """

    action: tyro.conf.Positional[Literal["install", "remove", "show"]]
    """What to do."""
    config: tyro.conf.Positional[Path]
    """The settings of `reflexarc run` (TOML); `reflexarc run … --show-config` prints one. For
    remove, the robot's name does as well."""
    user: str = ""
    """Run as this user; by default, as one that systemd makes for it."""
    writes: tuple[Path, ...] = ()
    """Folders of its --user that it may write to, beside its own, /var/lib/reflexarc-<robot>."""
    watchdog_s: float | None = None
    """Start it again when it has made no tick for so long; by default one and a half times what the
    loop's own timer allows it, at least 1 s."""
    units: Path = SYSTEM_UNITS
    """Folder of the units."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Install, remove or show the unit."""
        if self.action == "remove":
            self._remove()
            return 0
        settings = self._settings()
        unit = self._unit(settings)
        path = self.units / unit.name
        if self.action == "show":
            self._tell(unit.name, path, unit.text(), unit.text())
        else:
            self._install(settings, unit, path)
        return 0

    def _install(self, settings: "RunCommand", unit: "ServiceUnit", path: Path) -> None:
        from reflexarc.wiring.installing.service_access import check_access
        from reflexarc.wiring.installing.service_places import check_places
        from reflexarc_runtime.files import write_atomically

        check_places(settings.record, settings.recording, settings.box, unit)
        policies = {"policy": settings.policy, "shadow": settings.candidates.shadow}
        key = settings.trusting.require_signature
        check_access(unit, self.config.absolute(), policies, key)
        replace(settings, punctuality=settings.punctuality.unpressed).prepared()
        if not self.units.is_dir():
            raise UsageError(f"--units: {self.units}: no such folder; is systemd installed here?")
        write_atomically(path, unit.text().encode())
        started = self._systemctl("daemon-reload") and self._systemctl("enable", unit.name)
        then = f"systemctl restart {unit.name}"
        words = f"wrote {path}; next: {then if started else f'systemctl daemon-reload; {then}'}"
        self._tell(unit.name, path, words, unit.text())

    def _remove(self) -> None:
        from reflexarc_runtime.service.unit import folder_name, unit_name

        robot = self._robot()
        name, path = unit_name(robot), self.units / unit_name(robot)
        if not path.exists():
            raise UsageError(f"{path}: no such unit; installed under another --units?")
        self._systemctl("disable", "--now", name)
        text = path.read_text()
        path.unlink()
        self._systemctl("daemon-reload")
        words = f"removed {path}; its logs stay in /var/lib/{folder_name(robot)}"
        self._tell(name, path, words, text)

    def _robot(self) -> str:
        """Whose unit is to go: settings that are no longer valid, or gone, keep none of them."""
        from reflexarc_runtime.bus_config import ROBOT_NAME

        if not self.config.exists() and ROBOT_NAME.fullmatch(str(self.config)):
            return str(self.config)
        try:
            return self._settings().joining.robot
        except UsageError as error:
            raise UsageError(f"{error}; `reflexarc service remove ROBOT` needs no file") from None

    def _unit(self, settings: "RunCommand") -> "ServiceUnit":
        from reflexarc_logs.recording.recorder import PATIENCE_S
        from reflexarc_runtime.service.unit import ServiceUnit

        zenoh, config = settings.joining.zenoh, str(self.config.absolute())
        return ServiceUnit(
            robot=settings.joining.robot,
            command=(sys.executable, "-m", "reflexarc", "run", "--config", config),
            watchdog_s=self._watchdog_s(settings),
            stop_s=2 * PATIENCE_S + 5.0,  # of the whole run, and of a black box
            user=self.user,
            writes=self.writes,
            zenoh=None if zenoh is None else _without_dots(zenoh),
            networked=settings.metering.is_for_others,
            realtime_priority=settings.punctuality.settings.highest_priority,
            systemd_version=systemd_version(),
        )

    def _watchdog_s(self, settings: "RunCommand") -> float:
        """More than the loop's own timer allows: that one says what happened, and comes first."""
        own_s = _own_watchdog_s(settings)
        if self.watchdog_s is None:
            return max(LEAST_WATCHDOG_S, round(1.5 * own_s, 1))
        wanted = f"more than {own_s:g}, which this policy's loop may take by its own timer"
        require(self.watchdog_s > own_s, "--watchdog-s", wanted, f"{self.watchdog_s:g}")
        return self.watchdog_s

    def _settings(self) -> "RunCommand":
        from reflexarc.commands.drive.run import RunCommand
        from reflexarc.config_file.reading import settings_of

        if self.config.exists() and not self.config.is_file():
            raise UsageError(f"{self.config}: expected a file, which each start reads again")
        settings = settings_of(RunCommand, self.config)
        if not isinstance(settings.policy, Path):
            raise UsageError(f"{self.config}: policy: missing; expected the path of a policy")
        if settings.lockstep:
            raise UsageError(f"{self.config}: lockstep: expected a service in real time")
        if settings.ticks is not None:
            raise UsageError(f"{self.config}: ticks: expected a service that ends when it is told")
        try:
            settings.joining.config()  # the name of its robot is that of files and folders
        except UsageError as error:
            raise UsageError(f"{self.config}: {error}") from None
        return settings

    def _systemctl(self, *words: str) -> bool:
        """Ask the manager, if the unit is its own; whether it did."""
        return self.units == SYSTEM_UNITS and systemctl(*words)

    def _tell(self, unit: str, path: Path, words: str, text: str) -> None:
        if self.json:
            print_json({"unit": unit, "path": str(path), "text": text})
        elif self.action == "show":
            print(words, end="")
        else:
            console.print(words, soft_wrap=True)


def _without_dots(path: Path) -> Path:
    """An absolute path; links in it stay, unless `..` leads back out of one."""
    return path.resolve() if ".." in path.parts else path.absolute()


def _own_watchdog_s(settings: "RunCommand") -> float:
    """How long the loop of a policy may make no tick before its own timer ends it."""
    from reflexarc_runtime.policy.policy import load_contract

    accepted = settings.trusting.check_file(settings.policy)  # before anything of it is parsed
    contract = load_contract(accepted, bounds=settings.bounds, name=str(settings.policy))
    return settings.watching.budget(contract, settings.pacing.longest_wait_periods).process_s
