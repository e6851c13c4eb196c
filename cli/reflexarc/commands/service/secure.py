"""`reflexarc secure`: certificates and rights for a robot's bus, its doors, signed policies."""

import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import tyro

from reflexarc.terminal.output import console, plain, print_json
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc.securing.door_row import DoorRow
    from reflexarc.securing.secured_robot import SecuredRobot

_LONGEST_ROBOT = 54
"""A common name has at most 64 characters (RFC 5280), of which `recorder.` takes some."""
_MOST_DAYS = 3650.0
_LABEL = r"(?!-)[A-Za-z0-9_-]{1,63}(?<!-)"
_HOST_NAME = re.compile(rf"({_LABEL}\.)*(?![0-9]+$){_LABEL}")
"""RFC 1123, and underscores; the last label is no number, or it would be a mistyped address."""
_OPEN = 1


@dataclass(frozen=True)
class SecureCommand:
    """Let nobody onto a robot's bus but who has a certificate, and each do only what its role may.

    `init` makes a folder: an authority, and a Zenoh configuration for each role (body, runtime,
    recorder, operator, viewer), which holds its certificate, its key and nothing to be written by
    hand. Copy each to the machine of its role, and give it with --zenoh. `check` tries every door
    with real sessions, and says of each whether it is shut; with --connect also the door of a robot
    in use. Exit status: 0 all shut, 1 one is open, or does not open to whom it should. `renew`
    makes new certificates before the old ones expire. `key` and `sign` are for policies: see
    --require-signature of `reflexarc run`.

    Examples:
      reflexarc secure init keys --host 10.0.0.1
      reflexarc secure init keys --host rover1.local --robot rover1 --days 90
      reflexarc secure check keys
      reflexarc secure check keys --connect tls/10.0.0.1:7447
      reflexarc secure renew keys
      reflexarc secure key policies.key
      reflexarc secure sign runs/reflex-0/policy.onnx --key policies.key
    """

    action: tyro.conf.Positional[Literal["init", "check", "renew", "key", "sign"]]
    """What to do."""
    path: tyro.conf.Positional[Path]
    """The folder; for key and sign, the file."""
    robot: str = "robot0"
    """init: first part of every key on the bus."""
    host: tuple[str, ...] = ()
    """init: addresses and names by which other machines reach the door; none: this one alone."""
    port: int = 7447
    """init: the door's port."""
    door: Literal["body", "router"] = "body"
    """init: who listens: the body itself, or a Zenoh router beside it (zenohd -c router.json5)."""
    days: float | None = None
    """init, renew: how long certificates hold; 365."""
    role: tuple[str, ...] = ()
    """renew: whose certificates; everybody's by default."""
    connect: str = ""
    """check: the door of a robot in use, tls/host:port."""
    key: Path | None = None
    """sign: the secret key."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Do it; return the exit status."""
        if self.days is not None and not 0.0 < self.days <= _MOST_DAYS:
            raise UsageError(f"--days: expected above 0 to {_MOST_DAYS:g}, got {self.days}")
        return {
            "init": self._init,
            "check": self._check,
            "renew": self._renew,
            "key": self._key,
            "sign": self._sign,
        }[self.action]()

    def _init(self) -> int:
        from reflexarc.securing.security_folder import make_folder

        secured = self._secured()
        folder = make_folder(self.path, secured)
        if self.json:
            print_json({"folder": folder.path, "files": [folder.file(r) for r in secured.roles]})
        else:
            for line in _next_steps(self.path, secured):
                console.print(plain(line), soft_wrap=True)
        return 0

    def _secured(self) -> "SecuredRobot":
        from reflexarc.securing.secured_robot import SecuredRobot
        from reflexarc_runtime.bus_config import BusConfig

        BusConfig(self.robot, self.port)  # refuses a name that cannot be part of a key
        if len(self.robot) > _LONGEST_ROBOT:
            raise UsageError(f"--robot: expected at most {_LONGEST_ROBOT} characters")
        for host in self.host:
            _check_host(host)
        return SecuredRobot(self.robot, self.host, self.port, self.door, self.days or 365.0)

    def _check(self) -> int:
        from reflexarc.securing.door_trial import try_doors
        from reflexarc.securing.security_folder import SecurityFolder

        if self.connect:
            _check_locator(self.connect)
        rows = []
        for row in try_doors(SecurityFolder(self.path), self.connect):
            rows.append(row)
            if not self.json:
                console.print(plain(_line(row)), soft_wrap=True)
        if self.json:
            print_json(
                {
                    "doors": [asdict(row) for row in rows],
                    "shut": not any(row.is_bad for row in rows),
                }
            )
        return _OPEN if any(row.is_bad for row in rows) else 0

    def _renew(self) -> int:
        from reflexarc.securing.security_folder import SecurityFolder, renew

        renewed = renew(SecurityFolder(self.path), self.days, self.role)
        if self.json:
            print_json({"files": renewed})
        else:
            names = ", ".join(file.name for file in renewed)
            console.print(f"new: {plain(names)}", soft_wrap=True)
            console.print("copy each to its machine again, and start anew what uses it")
        return 0

    def _key(self) -> int:
        from reflexarc.securing.policy_keys import make_key

        public = make_key(self.path)
        self._told(secret=self.path, public=public)
        return 0

    def _sign(self) -> int:
        from reflexarc.securing.policy_keys import sign_file

        if self.key is None:
            raise UsageError("sign: expected --key FILE, the secret key (`reflexarc secure key`)")
        self._told(signature=sign_file(self.path, self.key))
        return 0

    def _told(self, **files: Path) -> None:
        if self.json:
            print_json(files)
            return
        for what, file in files.items():
            console.print(plain(f"{what}: {file}"), soft_wrap=True)


def _line(row: "DoorRow") -> str:
    return f"{row.state:<9}  {row.door}: {row.words}"


def _next_steps(path: Path, secured: "SecuredRobot") -> Iterator[str]:
    """What to copy where, and what to type there."""
    door, where = secured.door, ", ".join(secured.listeners)
    yield f"{path}: an authority and {len(secured.roles)} configurations, for {secured.days:g} days"
    yield f"the door is the {door}'s, at {where}"
    yield ""
    yield "copy each file to the machine of its role, as a secret (scp keeps mode 0600 with -p):"
    named = "" if secured.robot == "robot0" else f" --robot {secured.robot}"
    commands = {
        "router": "zenohd -c router.json5",
        "body": f"reflexarc sim --zenoh body.json5{named}",
        "runtime": f"reflexarc run POLICY.onnx --zenoh runtime.json5{named}",
        "recorder": f"reflexarc record --zenoh recorder.json5{named}",
        "operator": f"reflexarc stop --zenoh operator.json5{named}",
        "viewer": f"reflexarc view --zenoh viewer.json5{named}",
    }
    for role in secured.roles:
        yield f"  {path / role}.json5: {commands[role]}"
    yield ""
    yield "keep ca.key off the robot: who has it can make any certificate"
    yield f"try the doors: reflexarc secure check {path}"


def _check_host(host: str) -> None:
    from reflexarc.securing.authority import alternative_name

    expected = "an address or a name of a host, without port"
    if not host or len(host) > 253 or any(c.isspace() or c in "/#?;[]" for c in host):
        raise UsageError(f"--host: expected {expected}, got {host!r}")
    try:
        name = alternative_name(host)
    except ValueError as error:
        raise UsageError(f"--host: expected {expected}, got {host!r}: {error}") from None
    if isinstance(name.value, str) and not _HOST_NAME.fullmatch(host):
        raise UsageError(f"--host: expected {expected}, got {host!r}")
    if str(name.value) in ("0.0.0.0", "::"):
        raise UsageError(f"--host: {host} is no address that another machine can reach")


def _check_locator(locator: str) -> None:
    from reflexarc_runtime.doors.open_doors import host_and_port

    host, port = host_and_port(locator)
    if not locator.startswith("tls/") or not host or not port:
        raise UsageError(f"--connect: expected tls/HOST:PORT, got {locator!r}")
