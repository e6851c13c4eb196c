"""The player: sends each message when it is due, on a clock or in lockstep, and reports on it.

On a clock the source time of a message is the player's own time of sending, so that the age of an
input and the echo in a command mean the same as with any other body. In lockstep it is the log's
own time, and after each sensor message the player waits for its command.
"""

from collections import Counter, deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from reflexarc_logs.playing.schedule import Due
from reflexarc_runtime.loop.clock import Clock
from reflexarc_runtime.messages.topics import Topic

REMEMBERED_SENDS = 1 << 16
"""Percentiles rest on the last sends only, so that a loop may go on for ever."""
GLANCE_NS = 50_000_000
"""How often a waiting player checks whether it should pause or stop."""

Publish = Callable[[Topic, bytes, int], None]
"""Sends a payload on a topic with its source time."""


@dataclass(frozen=True, slots=True)
class PlaybackReport:
    """What was sent, and how late. Lateness is zero in lockstep, where nothing is due."""

    messages: dict[str, int]
    """By topic."""
    loops: int
    """How often the whole log was played."""
    seconds: float
    lateness_p50_ns: int
    lateness_p99_ns: int
    lateness_max_ns: int


def never() -> bool:
    """The default of `should_stop` and `is_paused`: nothing interrupts the player."""
    return False


class Player:
    """Plays one schedule.

    Args:
        clock: what due times and lateness are measured on.
        publish: called with topic, payload and source time.
        should_stop: whether to end; asked before every message and while waiting.
        is_paused: whether to hold; the rest of the schedule is late by the pause, and not counted
            as late.
        saw: told of every message that was sent.
    """

    def __init__(
        self,
        clock: Clock,
        publish: Publish,
        *,
        should_stop: Callable[[], bool] = never,
        is_paused: Callable[[], bool] = never,
        saw: Callable[[Due], None] = lambda due: None,
    ) -> None:
        self._clock = clock
        self._publish = publish
        self._should_stop = should_stop
        self._is_paused = is_paused
        self._saw = saw
        self._sent: Counter[str] = Counter()
        self._lateness_ns: deque[int] = deque(maxlen=REMEMBERED_SENDS)
        self._worst_ns = 0

    def play(self, schedule: Iterable[Due]) -> PlaybackReport:
        """Send every message when it is due, or as soon as possible after that."""
        began_ns = start_ns = self._clock.now_ns()
        loops = 0
        for due in schedule:
            held_ns = self._wait(start_ns + due.due_ns)
            if held_ns is None:
                return self._account(due.loop, began_ns)
            start_ns += held_ns
            now_ns = self._clock.now_ns()
            self._send(due, now_ns)
            self._note_lateness(now_ns - start_ns - due.due_ns)
            loops = due.loop + 1
        return self._account(loops, began_ns)

    def play_in_lockstep(
        self,
        schedule: Iterable[Due],
        origin_ns: int,
        sensor: str,
        await_command: Callable[[int], None],
    ) -> PlaybackReport:
        """Send every message on its own time; after one of the sensor, wait for its command.

        Args:
            schedule: at the speed 1.
            origin_ns: source time of what is due at 0.
            sensor: name of the topic that the runtime decides on.
            await_command: called with the number of the sensor message; raises if none comes.
        """
        began_ns = self._clock.now_ns()
        loops = 0
        for due in schedule:
            if self._wait(0) is None:
                return self._account(due.loop, began_ns)
            number = self._sent[sensor]
            self._send(due, origin_ns + due.due_ns)
            if due.topic.name == sensor:
                await_command(number)
            loops = due.loop + 1
        return self._account(loops, began_ns)

    def _wait(self, due_ns: int) -> int | None:
        """Wait until a time; how long the player was held meanwhile, or None: it should stop."""
        held_ns = 0
        while not self._should_stop():
            now_ns = self._clock.now_ns()
            if self._is_paused():
                self._clock.sleep_until_ns(now_ns + GLANCE_NS)
                held_ns += self._clock.now_ns() - now_ns
            elif now_ns >= due_ns + held_ns:
                return held_ns
            else:
                self._clock.sleep_until_ns(min(due_ns + held_ns, now_ns + GLANCE_NS))
        return None

    def _send(self, due: Due, time_ns: int) -> None:
        self._publish(due.topic, due.record.payload, time_ns)
        self._sent[due.topic.name] += 1
        self._saw(due)

    def _note_lateness(self, lateness_ns: int) -> None:
        self._lateness_ns.append(lateness_ns)
        self._worst_ns = max(self._worst_ns, lateness_ns)

    def _account(self, loops: int, began_ns: int) -> PlaybackReport:
        p50, p99 = np.percentile(self._lateness_ns or [0], [50, 99])
        return PlaybackReport(
            messages=dict(self._sent),
            loops=loops,
            seconds=(self._clock.now_ns() - began_ns) / 1e9,
            lateness_p50_ns=int(p50),
            lateness_p99_ns=int(p99),
            lateness_max_ns=self._worst_ns,
        )
