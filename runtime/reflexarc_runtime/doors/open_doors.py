"""Through which doors of a Zenoh configuration anybody could come in.

Read from the resolved configuration, so that what a file leaves out counts as Zenoh's default: a
peer that says nothing listens in plain TCP on all interfaces, and calls by multicast.
"""

import ipaddress
from collections.abc import Callable, Iterator
from typing import Any

Setting = Callable[[str], Any]
"""The value of a setting by its path, `listen/endpoints`; None where it is left to Zenoh."""

_ON_THIS_MACHINE = ("unixsock-stream", "unixpipe", "serial")
_WITH_CERTIFICATES = ("tls", "quic")
_LOOPBACK_INTERFACES = ("lo", "127.0.0.1", "::1")


def open_doors(setting: Setting) -> list[str]:
    """What lets strangers in, in words; empty if nothing does."""
    return [*_open_listeners(setting), *_multicast(setting)]


def listeners(setting: Setting) -> list[str]:
    """The locators on which a session with this configuration listens."""
    return _endpoints(setting, "listen/endpoints")


def connections(setting: Setting) -> list[str]:
    """The locators to which it connects."""
    return _endpoints(setting, "connect/endpoints")


def host_and_port(locator: str) -> tuple[str, int]:
    """The address in a locator, `tls/[::1]:7447?rel=1#iface=lo`; port 0 where there is none."""
    address = locator.partition("/")[2].partition("?")[0].partition("#")[0]
    host, _, port = address.rpartition(":")
    return host.strip("[]"), int(port) if port.isdecimal() else 0


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches an address. A name is believed only if it is localhost."""
    try:
        return ipaddress.ip_address(host.partition("%")[0]).is_loopback
    except ValueError:
        return host == "localhost"


def _open_listeners(setting: Setting) -> Iterator[str]:
    for locator in listeners(setting):
        protocol = locator.partition("/")[0]
        if protocol in _ON_THIS_MACHINE or is_loopback(host_and_port(locator)[0]):
            continue
        if protocol not in _WITH_CERTIFICATES:
            yield f"listens on {locator}, which lets in whoever reaches it"
        elif not _asks_for_certificates(setting, locator):
            yield f"listens on {locator}, which asks nobody for a certificate (enable_mtls)"


def _asks_for_certificates(setting: Setting, locator: str) -> bool:
    """What the locator itself says of it comes before the setting."""
    _, _, own = locator.partition("#")
    for pair in own.split(";"):
        name, _, value = pair.partition("=")
        if name == "enable_mtls":
            return value == "true"
    return (setting("transport/link/tls") or {}).get("enable_mtls") is True


def _multicast(setting: Setting) -> Iterator[str]:
    """Scouting answers strangers, and connects to those that answer.

    A client that is told its router looks for no other.
    """
    if setting("scouting/multicast/enabled") is False:
        return
    if setting("scouting/multicast/interface") in _LOOPBACK_INTERFACES:
        return
    if _mode(setting) == "client" and connections(setting):
        return
    yield "looks for others by multicast (scouting/multicast/enabled)"


def _mode(setting: Setting) -> str:
    return setting("mode") or "peer"


def _endpoints(setting: Setting, path: str) -> list[str]:
    """A list, or one for each mode."""
    value = setting(path) or []
    if isinstance(value, dict):
        value = value.get(_mode(setting)) or []
    return list(_locators(value))


def _locators(value: object) -> Iterator[str]:
    """Zenoh nests them: one, several, or groups with a strategy."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        yield from _locators(value.get("locators") or [])
    elif isinstance(value, list):
        for each in value:
            yield from _locators(each)
