"""The unit file by which systemd keeps a robot's loop running, with as few rights as it needs.

What stands in it, and why, is in systemd.service(5), systemd.exec(5) and systemd.kill(5).
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from reflexarc_runtime.config.checks import require

BACK_OFF_SINCE = 254
"""The first version of systemd that waits longer after each failure (RestartSteps)."""
BACK_OFF_STEPS = 8
FIRST_RESTART_S = 0.2
LONGEST_RESTART_S = 30
SYSTEMCTL = "/usr/bin/systemctl"
START_S = 60
"""A policy is tried in a process of its own before the loop begins, on a slow machine for long."""
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
    """Folders beside its own that it may write to."""
    networked: bool = False
    """Whether it may speak to other machines; else to this one alone."""
    realtime_priority: int = 0
    """The highest SCHED_FIFO priority that it may take; 0: none."""
    systemd_version: int = BACK_OFF_SINCE

    def __post_init__(self) -> None:
        require(0.5 <= self.watchdog_s <= 600, "--watchdog-s", "0.5 to 600", self.watchdog_s)
        for path in self.writes:
            require(path.is_absolute(), "--writes", "an absolute path", path)
        for word in (*self.command, *map(str, self.writes)):
            require(word.isprintable(), "service", "words on one line", repr(word))

    @property
    def name(self) -> str:
        """Name of its file."""
        return f"reflexarc-{self.robot}.service"

    @property
    def folder(self) -> str:
        """Its own folder below /var/lib, which systemd makes; logs may go there."""
        return f"reflexarc-{self.robot}"

    def text(self) -> str:
        """The whole file."""
        return "\n".join([*self._unit(), "", *self._service(), "", *_INSTALL]) + "\n"

    def _unit(self) -> Iterator[str]:
        yield "[Unit]"
        yield f"Description=reflexarc: the sense-act loop of {self.robot}"
        yield "Wants=network-online.target" if self.networked else "Wants=network.target"
        yield "After=network-online.target" if self.networked else "After=network.target"
        yield "# It is started again for ever, later and later."
        yield "StartLimitIntervalSec=0"

    def _service(self) -> Iterator[str]:
        yield "[Service]"
        yield "# Ready after its first tick; each tick feeds the watchdog."
        yield "Type=notify"
        yield "NotifyAccess=main"
        yield f"ExecStart={_command_line(self.command)}"
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

    def _rights(self) -> Iterator[str]:
        yield "# What it may do: compute, speak on its sockets, write into its own folder."
        yield f"User={self.user}" if self.user else "DynamicUser=yes"
        yield f"StateDirectory={self.folder}"
        yield "StateDirectoryMode=0750"
        for path in self.writes:
            yield f"ReadWritePaths={_escaped(str(path))}"
        yield "UMask=0027"
        yield f"LimitRTPRIO={self.realtime_priority}"
        yield f"RestrictRealtime={'no' if self.realtime_priority else 'yes'}"
        if self.realtime_priority:
            yield "LimitMEMLOCK=infinity"
        if not self.networked:
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

_INSTALL = ("[Install]", "WantedBy=multi-user.target")


def _command_line(words: tuple[str, ...]) -> str:
    return " ".join(_escaped(word) for word in words)


def _escaped(word: str) -> str:
    """A word as systemd reads it: its own signs doubled, in quotes where it has to be."""
    doubled = word.replace("%", "%%").replace("$", "$$")
    if _PLAIN.fullmatch(word):
        return doubled
    return '"' + doubled.replace("\\", "\\\\").replace('"', '\\"') + '"'
