"""The body on the bus while a log is played: publishes its streams, and hears commands."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from reflexarc_runtime.loop import lockstep
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.messages.topics import BODY_NODE, BODY_TOPICS, COMMAND, RUNTIME_NODE, Topic

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus


class PlayingBody:
    """Publishes the messages of a log; obeys no command.

    Args:
        bus: an open session that listens, as bodies do.
        sensor: name of the topic that the runtime decides on.
        should_stop: whether to stop waiting.
    """

    def __init__(self, bus: "Bus", sensor: str, should_stop: Callable[[], bool]) -> None:
        self._bus = bus
        self._sensor = sensor
        self._should_stop = should_stop
        self._inbox = Inbox()
        self._publishers = {topic.name: bus.publisher(topic) for topic in BODY_TOPICS}
        bus.subscribe([COMMAND], self._inbox.put)
        bus.announce(BODY_NODE)

    def publish(self, topic: Topic, payload: bytes, time_ns: int) -> None:
        """Send one message, with the next number of its topic."""
        self._publishers[topic.name].put(payload, time_ns)

    def wait_for_runtime(self) -> None:
        """Wait for a runtime: in lockstep, a message without a listener would never be answered."""
        lockstep.wait_for_runtime(self._inbox, self.is_heard, self._should_stop)

    def await_command(self, number: int) -> None:
        """Wait for the command of a sensor message.

        Raises:
            BusError: it did not come.
        """
        lockstep.await_command(self._inbox, number, lambda command: None, self._should_stop)

    def is_heard(self) -> bool:
        """Whether a runtime is there and listens to the sensor."""
        return self._publishers[self._sensor].has_listener and self._bus.is_alive(RUNTIME_NODE)
