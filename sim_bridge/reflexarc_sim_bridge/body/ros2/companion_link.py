"""The bridge's end of its companion: starts it, sees whether it lives, says farewell.

The companion gets a session of its own (setsid): what is sent to the bridge's process group or to
its terminal does not reach it. It must listen before the bridge says anything that moves the robot.
"""

import logging
import select
import subprocess
import sys
from types import TracebackType
from typing import Self

from reflexarc_runtime.errors import BusError
from reflexarc_sim_bridge.body.ros2.companion import FAREWELL, READY, Watched

START_S = 30.0
"""A cold start on a slow computer takes seconds; longer than this it hangs."""
END_S = 3.0
"""How long it may take to close its session before it is killed."""

_MODULE = "reflexarc_sim_bridge.body.ros2.companion"
_LOG = logging.getLogger(__name__)


class CompanionLink:
    """A running companion; leaving the context says farewell to it.

    Args:
        watched: what it shall listen to.

    Raises:
        BusError: it does not start.
    """

    def __init__(self, watched: Watched) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", _MODULE, watched.text()],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
            bufsize=0,
        )
        self._said_lost = False
        self._await_ready()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.end()

    @property
    def process_id(self) -> int:
        """Its number, for whoever looks after processes."""
        return self._process.pid

    def is_alive(self) -> bool:
        """Whether it runs; that it does not is said once."""
        if self._process.poll() is None:
            return True
        if not self._said_lost:
            self._said_lost = True
            _LOG.warning(
                "the bridge's companion has ended (status %s): nobody watches the twists; "
                "start the bridge again when the robot stands",
                self._process.returncode,
            )
        return False

    def end(self) -> None:
        """Say farewell and wait for its end, so that no zombie stays."""
        try:
            self._process.communicate(FAREWELL, timeout=END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.communicate()

    def _await_ready(self) -> None:
        output = self._process.stdout
        assert output is not None  # it was asked for as a pipe
        can_be_read = select.select([output], [], [], START_S)[0]
        if can_be_read and output.readline() == READY:
            return
        self._process.kill()
        self._process.communicate()
        raise BusError(
            "the bridge's companion does not start, so nobody would stop the robot if the bridge "
            "were killed; --no-companion to go without"
        )
