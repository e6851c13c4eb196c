"""The unit file by which systemd keeps a robot's loop running, with as few rights as it needs.

What stands in it, and why, is in systemd.service(5), systemd.exec(5) and systemd.kill(5).
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from reflexarc_runtime.bus_config import ROBOT_NAME, ROBOT_NAME_IN_WORDS
from reflexarc_runtime.config.checks import require

BACK_OFF_SINCE = 254
"""The first version of systemd that waits longer after each failure (RestartSteps)."""
CREDENTIALS_SINCE = 247
"""The first version that hands files to a service which its user may not read (LoadCredential)."""
BACK_OFF_STEPS = 8
FIRST_RESTART_S = 0.2
LONGEST_RESTART_S = 30
SYSTEMCTL = "/usr/bin/systemctl"
START_S = 90
"""A policy is tried in a process of its own before the loop begins, on a slow machine for long:
that alone may take 65 s. Who waits for a door says so, and may take as long as that lasts."""
WRONG_USE = 2
"""Exit status of a wrong flag or a bad policy; also of a disk that is full, or not there yet."""


@dataclass(frozen=True)
class ServiceUnit:
    """What the unit of one robot says."""

    robot: str
    command: tuple[str, ...]
    """What is run, in absolute paths."""
    watchdog_s: float = 1.0
    """How long the loop may make no tick before the manager ends the process."""
    stop_s: float = 30.0
    """How long it may take to end, its log included."""
    user: str = ""
    """Whom it runs as; empty: a user that systemd makes for it."""
    writes: tuple[Path, ...] = ()
    """Folders beside its own that it may write to. They have to be its user's: who made them stays
    their owner, and a user that systemd makes for each start owns nothing."""
    zenoh: Path | None = None
    """Its Zenoh configuration, which may hold a key; with one it may speak to other machines."""
    networked: bool = False
    """Whether it may do so without one as well; else it speaks to this machine alone."""
    realtime_priority: int = 0
    """The highest SCHED_FIFO priority that it may take; 0: none."""
    systemd_version: int = BACK_OFF_SINCE

    def __post_init__(self) -> None:
        is_name = ROBOT_NAME.fullmatch(self.robot) is not None
        require(is_name, "robot", ROBOT_NAME_IN_WORDS, repr(self.robot))
        is_user = not self.user or _USER.fullmatch(self.user) is not None
        require(is_user, "--user", "the name or number of a user", repr(self.user))
        require(0.5 <= self.watchdog_s <= 600, "--watchdog-s", "0.5 to 600", self.watchdog_s)
        for word in (*self.command, *map(str, self._paths)):
            require(word.isprintable(), "service", "words on one line", repr(word))
        require("$" not in self.command[0], "service", "an interpreter without $", self.command[0])
        self._check_writes()
        self._check_zenoh()

    def _check_writes(self) -> None:
        """What the quotes of a list of paths cannot hold, and what nobody could write to."""
        wanted = "an absolute path without .., quotes and backslashes"
        for path in self.writes:
            is_plain = not set(str(path)) & set("\"'\\")
            is_plain = is_plain and path.is_absolute() and ".." not in path.parts
            require(is_plain, "--writes", wanted, repr(str(path)))
        wanted = "--user NAME beside it, whose they are: a user that systemd makes owns no folder"
        require(bool(self.user) or not self.writes, "--writes", wanted, "none")

    def _check_zenoh(self) -> None:
        """A credential's path is read up to the end of its line, without quotes."""
        if self.zenoh is not None:
            path, wanted = str(self.zenoh), "an absolute path without .. that ends in a letter"
            is_plain = self.zenoh.is_absolute() and ".." not in self.zenoh.parts
            require(is_plain and path[-1] not in " \\", "zenoh", wanted, repr(path))

    @property
    def _paths(self) -> tuple[Path, ...]:
        return self.writes if self.zenoh is None else (*self.writes, self.zenoh)

    @property
    def name(self) -> str:
        """Name of its file."""
        return unit_name(self.robot)

    @property
    def credential(self) -> str:
        """Under which name systemd hands it the Zenoh configuration; empty if it does not.

        The file is its owner's secret, whom a user that systemd makes can never be.
        """
        if self.zenoh is None or self.systemd_version < CREDENTIALS_SINCE:
            return ""
        suffix = self.zenoh.suffix  # by which Zenoh knows how it is written
        return f"zenoh{suffix if _SUFFIX.fullmatch(suffix) else '.json5'}"

    @property
    def folder(self) -> str:
        """Its own folder below /var/lib, which systemd makes; logs may go there."""
        return folder_name(self.robot)

    def text(self) -> str:
        """The whole file."""
        return "\n".join([*self._unit(), "", *self._service(), "", *_INSTALL]) + "\n"

    def _unit(self) -> Iterator[str]:
        yield "[Unit]"
        yield f"Description=reflexarc: the sense-act loop of {self.robot}"
        yield f"Wants={self._network}"
        yield f"After={self._network}"
        yield "# It is started again for ever, later and later."
        yield "StartLimitIntervalSec=0"

    @property
    def _network(self) -> str:
        return "network-online.target" if self._is_networked else "network.target"

    @property
    def _is_networked(self) -> bool:
        return self.networked or self.zenoh is not None

    def _service(self) -> Iterator[str]:
        yield "[Service]"
        yield "# Ready after its first tick; each tick feeds the watchdog."
        yield "Type=notify"
        yield "NotifyAccess=main"
        yield f"ExecStart={self._command_line()}"
        yield f"WorkingDirectory=%S/{self.folder}"
        yield f"WatchdogSec={self.watchdog_s:g}"
        yield f"TimeoutStartSec={START_S}"
        yield "# SIGTERM ends in a safe command and a finished log, which takes a moment."
        yield f"TimeoutStopSec={self.stop_s:g}"
        yield "KillMode=mixed"
        yield "Restart=on-failure"
        yield f"RestartSec={FIRST_RESTART_S:g}"
        yield from self._back_off()
        yield ""
        yield from self._rights()

    def _back_off(self) -> Iterator[str]:
        """A start that fails is tried again later and later; once one is ready, as at first.

        systemd by itself never counts anew: after eight deaths in as many years it would wait for
        the longest time at each (its issue 43813), while the robot stands.
        """
        if self.systemd_version < BACK_OFF_SINCE:
            yield "# Nobody waits longer each time here: a wrong flag is not tried again for ever."
            yield f"RestartPreventExitStatus={WRONG_USE}"
            return
        yield f"RestartSteps={BACK_OFF_STEPS}"
        yield f"RestartMaxDelaySec={LONGEST_RESTART_S}"
        yield "# Its first tick ends the waiting: failures are counted from the last good start."
        yield f"ExecStartPost=-+{SYSTEMCTL} reset-failed {self.name}"

    def _command_line(self) -> str:
        """Only behind the first word systemd reads variables, `$`; `%` it reads everywhere."""
        first, *others = self.command
        words = [_quoted(_specified(first))]
        words += [_quoted(_specified(word).replace("$", "$$")) for word in others]
        if self.credential:  # what the command line says counts more than the file of settings
            words += ["--zenoh", f"${{CREDENTIALS_DIRECTORY}}/{self.credential}"]
        return " ".join(words)

    def _rights(self) -> Iterator[str]:
        yield "# What it may do: compute, speak on its sockets, write into its own folder."
        yield f"User={self.user}" if self.user else "DynamicUser=yes"
        yield f"StateDirectory={self.folder}"
        yield "StateDirectoryMode=0750"
        if self.credential:
            yield f"LoadCredential={self.credential}:{_specified(str(self.zenoh))}"
        for path in self.writes:
            yield f"ReadWritePaths={_quoted(_specified(str(path)))}"
        yield "UMask=0027"
        yield f"LimitRTPRIO={self.realtime_priority}"
        yield f"RestrictRealtime={'no' if self.realtime_priority else 'yes'}"
        if self.realtime_priority:
            yield "LimitMEMLOCK=infinity"
        if not self._is_networked:
            yield "IPAddressDeny=any"
            yield "IPAddressAllow=localhost"
        yield from _FEW_RIGHTS


_FEW_RIGHTS = (
    "RestrictAddressFamilies=AF_UNIX AF_INET AF_INET6 AF_NETLINK",
    "CapabilityBoundingSet=",
    "AmbientCapabilities=",
    "NoNewPrivileges=yes",
    "ProtectSystem=strict",
    "ProtectHome=read-only",
    "PrivateTmp=yes",
    "PrivateDevices=yes",
    "PrivateMounts=yes",
    "ProtectClock=yes",
    "ProtectHostname=yes",
    "ProtectKernelLogs=yes",
    "ProtectKernelModules=yes",
    "ProtectKernelTunables=yes",
    "ProtectControlGroups=yes",
    "ProtectProc=invisible",
    "RestrictNamespaces=yes",
    "RestrictSUIDSGID=yes",
    "LockPersonality=yes",
    "MemoryDenyWriteExecute=yes",
    "RemoveIPC=yes",
    "KeyringMode=private",
    "SystemCallArchitectures=native",
    "SystemCallFilter=@system-service",
    "SystemCallFilter=~@privileged",
    "SystemCallErrorNumber=EPERM",
)

_PLAIN = re.compile(r"[\w@%$+=:,./-]+")
_SUFFIX = re.compile(r"\.[A-Za-z0-9]{1,8}")
_USER = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]{0,30}|[0-9]{1,10}")

_INSTALL = ("[Install]", "WantedBy=multi-user.target")


def unit_name(robot: str) -> str:
    """Name of the unit file of a robot."""
    return f"reflexarc-{robot}.service"


def folder_name(robot: str) -> str:
    """Name of the folder of a robot, below /var/lib."""
    return f"reflexarc-{robot}"


def _specified(word: str) -> str:
    """A word in which systemd finds no specifier of its own."""
    return word.replace("%", "%%")


def _quoted(word: str) -> str:
    """A word that stays one, in quotes where it has to be."""
    if _PLAIN.fullmatch(word):
        return word
    return '"' + word.replace("\\", "\\\\").replace('"', '\\"') + '"'
