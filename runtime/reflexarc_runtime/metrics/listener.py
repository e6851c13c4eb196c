"""The socket on which metrics are scraped: loopback unless it is told otherwise."""

import socket

from reflexarc_runtime.errors import UsageError

_WAITING = 32
"""Connections that the kernel lets wait."""


def listener_at(host: str, port: int) -> socket.socket:
    """A socket that listens.

    Raises:
        UsageError: the port is in use, or the machine has no such address, or nobody can have it.
    """
    try:
        family, kind, number, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        listener = socket.socket(family, kind, number)
    except OSError as error:
        raise UsageError(_refusal(host, port, error)) from None
    except UnicodeError:  # an empty label, or one of more than 63 characters
        raise UsageError(f"--metrics-host: expected the name of a host, got {host!r:.80}") from None
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(_WAITING)
    except OSError as error:
        listener.close()
        raise UsageError(_refusal(host, port, error)) from None
    return listener


def address_of(listener: socket.socket) -> str:
    """Where a browser, or Prometheus, finds it."""
    host, port = listener.getsockname()[:2]
    return f"http://{f'[{host}]' if ':' in host else host}:{port}/metrics"


def _refusal(host: str, port: int, error: OSError) -> str:
    return (
        f"--metrics {port}: expected a free port of {host}, got: {error.strerror}; "
        "choose another, or 0 for any that is free"
    )
