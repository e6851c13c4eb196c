"""Starts Rerun's viewer so that it listens on this machine only.

By itself it listens on every address: whoever is on the network could see the robot, and send
drawings of their own.
"""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time

from reflexarc_runtime.errors import LogError, UsageError

HERE = "127.0.0.1"
PATIENCE_S = 20.0
_POLL_S = 0.1


def open_window(port: int) -> None:
    """Start Rerun's own window, which stays when we end; one that is open already is used.

    Raises:
        LogError: it cannot be started.
    """
    if not _answers(port):
        _wait(_start(port, "--expect-data-soon"), port)


def serve_page(port: int, page_port: int) -> "subprocess.Popen[bytes]":
    """Start the page for a browser; it ends when what is returned is given to `end`.

    Raises:
        UsageError: a port is taken.
        LogError: it cannot be started.
    """
    for taken in (port, page_port):
        if _answers(taken):
            raise UsageError(f"port {taken} is taken; is another viewer open?")
    viewer = _start(port, "--serve-web", "--web-viewer-port", str(page_port))
    _wait(viewer, port)
    return viewer


def end(viewer: "subprocess.Popen[bytes]") -> None:
    """End a viewer that was started, and the program that it is only the door of."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(viewer.pid, signal.SIGTERM)
    with contextlib.suppress(subprocess.TimeoutExpired):
        viewer.wait(PATIENCE_S)


def source_of(port: int) -> str:
    """Where a viewer takes its data from."""
    return f"rerun+http://{HERE}:{port}/proxy"


def page_of(port: int, page_port: int) -> str:
    """What a browser opens."""
    source = source_of(port).replace("+", "%2B").replace(":", "%3A").replace("/", "%2F")
    return f"http://{HERE}:{page_port}/?url={source}"


def _start(port: int, *flags: str) -> "subprocess.Popen[bytes]":
    words = [sys.executable, "-m", "rerun", "--bind", HERE, "--port", str(port), *flags]
    return subprocess.Popen(
        words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )


def _wait(viewer: "subprocess.Popen[bytes]", port: int) -> None:
    until_s = time.monotonic() + PATIENCE_S
    while not _answers(port):
        if viewer.poll() is not None:
            raise LogError("Rerun's viewer ended at once; no display here? --web, or -o FILE.rrd")
        if time.monotonic() > until_s:
            end(viewer)
            raise LogError(f"Rerun's viewer does not answer on port {port}")
        time.sleep(_POLL_S)


def _answers(port: int) -> bool:
    with socket.socket() as probe:
        probe.settimeout(1.0)
        return probe.connect_ex((HERE, port)) == 0
