"""Tells a person what is wrong with the inputs, once a change, and never holds the loop up."""

import re
import threading
from collections.abc import Callable
from queue import Empty, Full, Queue
from types import TracebackType
from typing import Self

from reflexarc_runtime.backlog import BACKLOG
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import Decision, Verdict
from reflexarc_runtime.loop.notices.sensor_period import SensorPeriod, misfit

TOLD = (Verdict.INVALID_INPUT, Verdict.TWO_SOURCES)
"""Verdicts whose reasons a person should read."""

_NUMBER = re.compile(r"[\d.]+")
_WAITING = 8
_LEAST_S = 1.0
"""Between two notices: reasons that take turns must not fill a terminal."""
_CHECK_S = 0.2


class Notices:
    """Says what is wrong with the inputs; a context manager that owns the thread that says it.

    Args:
        say: prints a line.
        contract: of the policy.
        sensor: what the loop decides on: retina, scan.
    """

    def __init__(self, say: Callable[[str], None], contract: PolicyContract, sensor: str) -> None:
        self._say, self._contract, self._kind_of_sensor = say, contract, sensor
        self._period = SensorPeriod()
        self._kind = ""
        self._misfit = ""
        self._queue: Queue[str] = Queue(_WAITING)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._speak, name="notices", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended.set()
        self._thread.join(2 * _CHECK_S)

    def saw(self, decision: Decision) -> None:
        """Look at a tick; called on the loop's thread, it never waits."""
        if decision.verdict in TOLD or decision.reason.endswith(BACKLOG):
            kind = _NUMBER.sub("#", decision.reason)
            if kind != self._kind:
                self._kind = kind
                self._put(f"{decision.verdict.name}: {decision.reason}")
        elif decision.verdict is Verdict.OK:
            self._kind = ""
        if decision.input is not None:
            self._look_at_period(decision.input.received_ns)

    def sensor(self, now_ns: int) -> str:
        """How often inputs come, and whether the policy can live with it; for the status."""
        return self._misfit or self._period.in_words(now_ns, self._kind_of_sensor)

    def _look_at_period(self, received_ns: int) -> None:
        if not self._period.saw(received_ns) or self._period.period_ns is None:
            return
        words = misfit(self._period, self._contract, self._kind_of_sensor)
        if words and not self._misfit:
            self._put(words)
        self._misfit = words

    def _put(self, words: str) -> None:
        try:
            self._queue.put_nowait(words)
        except Full:
            return  # a terminal that stands still; the log has every reason

    def _speak(self) -> None:
        while not self._ended.wait(_CHECK_S):
            try:
                words = self._queue.get_nowait()
            except Empty:
                continue
            self._say(words)
            self._ended.wait(_LEAST_S)
