"""One robot with its door and its roles, and the Zenoh configuration of each, in one file each.

Everybody is a client of one door, which the body keeps, or a Zenoh router beside it: so one place
checks all rights, and nobody else listens. A file holds its certificate and its key in itself, so
that it is the only one to copy.
"""

import base64
import ipaddress
import json
from dataclasses import asdict, dataclass
from typing import Any, Literal

from reflexarc.securing.access_rules import access_control
from reflexarc.securing.authority import Authority, Identity, Validity
from reflexarc_runtime.bus_config import MAX_MESSAGE_BYTES
from reflexarc_runtime.doors.open_doors import is_loopback
from reflexarc_runtime.messages.access import ROLES, ROUTER, common_name

LOOPBACKS = ("127.0.0.1", "localhost")
"""Always names of the door: on its own machine it is reached without a network."""
ALL_INTERFACES = "0.0.0.0"
RETRY = {"period_init_ms": 50, "period_max_ms": 500, "period_increase_factor": 2}
ONCE = 0
"""Milliseconds for which a client of several doors tries again before it says that all are shut.
Zenoh would spend them on the first one alone; once it was in, it tries all of them for ever."""
OPEN_MS = 2000
"""How long one door may take to answer."""

DoorKeeper = Literal["body", "router"]


@dataclass(frozen=True)
class SecuredRobot:
    """Which robot, and where its door is."""

    robot: str
    hosts: tuple[str, ...]
    """Addresses and names by which other machines reach the door; none: this machine alone."""
    port: int
    door: DoorKeeper
    """Who keeps it."""
    days: float
    """How long certificates hold."""

    @property
    def roles(self) -> tuple[str, ...]:
        """Everybody who has a file."""
        return (ROUTER, *ROLES) if self.door == ROUTER else ROLES

    @property
    def guests(self) -> tuple[str, ...]:
        """Everybody who comes to the door."""
        return tuple(role for role in self.roles if role != self.door)

    @property
    def listeners(self) -> list[str]:
        """Where the door is: at its addresses, or on all interfaces if it has only names."""
        beyond = [host for host in self.hosts if not is_loopback(host)]
        addresses = [host for host in beyond if _is_address(host)]
        if beyond and not addresses:
            return [self._locator(ALL_INTERFACES)]
        return [self._locator(host) for host in dict.fromkeys((LOOPBACKS[0], *addresses))]

    @property
    def doors(self) -> list[str]:
        """Where guests look for it: on their own machine first, which needs no network."""
        return [self._locator(host) for host in dict.fromkeys((LOOPBACKS[0], *self.hosts))]

    def identity(self, role: str, authority: Authority, valid: Validity) -> Identity:
        """A new certificate of a role."""
        hosts = tuple(dict.fromkeys((*self.hosts, *LOOPBACKS))) if role == self.door else ()
        return authority.issue(common_name(role, self.robot), valid, hosts)

    def settings(self, role: str, known: bytes, own: Identity) -> dict[str, Any]:
        """The Zenoh configuration of a role.

        Args:
            role: whose.
            known: the authority's certificate.
            own: the role's.
        """
        shared = {
            "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
            "transport": {
                "unicast": {"open_timeout": OPEN_MS},
                "link": {
                    "protocols": ["tls"],
                    "rx": {"max_message_size": MAX_MESSAGE_BYTES},
                    "tls": _tls(known, own, listens=role == self.door),
                },
                "shared_memory": {"enabled": False},
            },
        }
        if role == self.door:
            return {
                "mode": "router",
                "listen": {"endpoints": self.listeners},
                **shared,
                "access_control": access_control(self.robot, self.guests),
            }
        connect = {"endpoints": self.doors, "timeout_ms": ONCE, "retry": RETRY}
        return {"mode": "client", "connect": connect, **shared}

    def text(self, role: str, known: bytes, own: Identity) -> str:
        """The file of a role."""
        settings = json.dumps(self.settings(role, known, own), indent=1)
        return f"{_HEADER.format(role=role, robot=self.robot)}{settings}\n"

    def as_json(self) -> str:
        """What `renew` needs to know again."""
        return json.dumps(asdict(self), indent=1) + "\n"

    def _locator(self, host: str) -> str:
        shown = f"[{host}]" if ":" in host else host
        return f"tls/{shown}:{self.port}"


_HEADER = """\
// Zenoh configuration of the {role} of {robot}, by `reflexarc secure`. It holds a secret key:
// copy it to the machine of the {role} alone, and let nobody else read it there.
"""


def parse_secured_robot(text: str) -> SecuredRobot:
    """What was kept.

    Raises:
        ValueError: it is none of ours.
    """
    try:
        fields = json.loads(text)
        return SecuredRobot(**{**fields, "hosts": tuple(fields["hosts"])})
    except (TypeError, KeyError) as error:
        raise ValueError(str(error)) from None


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True


def _tls(known: bytes, own: Identity, *, listens: bool) -> dict[str, Any]:
    sides = ("connect", "listen") if listens else ("connect",)
    settings: dict[str, Any] = {
        "enable_mtls": True,
        "verify_name_on_connect": True,
        "close_link_on_expiration": True,
        "root_ca_certificate_base64": base64_of(known),
    }
    for side in sides:
        settings[f"{side}_certificate_base64"] = base64_of(own.certificate)
        settings[f"{side}_private_key_base64"] = base64_of(own.key)
    return settings


def base64_of(pem: bytes) -> str:
    """As Zenoh takes PEM within a file."""
    return base64.b64encode(pem).decode("ascii")
