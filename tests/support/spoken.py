"""A publisher that keeps what it is given, and a bus that keeps who listens to it."""

from typing import Any

from support.gates import BODY
from support.ros2 import Twist


class Spoken:
    """A publisher that keeps what it is given."""

    def __init__(self) -> None:
        self.said: list[tuple[bytes, int]] = []

    def put(self, payload: bytes, time_ns: int) -> None:
        self.said.append((payload, time_ns))

    @property
    def speeds(self) -> list[tuple[float, float, float]]:
        """Of the twists: ahead, to the left, counter-clockwise."""
        twists = [Twist.deserialize(payload) for payload, _ in self.said]
        return [(twist.linear.x, twist.linear.y, twist.angular.z) for twist in twists]


class FakeBus:
    """Remembers what was declared."""

    session_id = "ab"
    sender = BODY

    def __init__(self) -> None:
        self.publishers: dict[str, Spoken] = {}
        self.heard: dict[str, Any] = {}
        self.tokens: list[str] = []
        self.asked: list[str] = []

    def publisher(self, topic: Any) -> Spoken:
        return self.publishers.setdefault(topic.name, Spoken())

    def publisher_of_key(self, key: str, encoding: str, quality: Any) -> Spoken:
        return self.publishers.setdefault(key, Spoken())

    def subscribe(self, topics: Any, deliver: Any) -> None:
        self.heard.update((topic.name, deliver) for topic in topics)

    def subscribe_to_key(self, key: str, deliver: Any) -> None:
        self.heard[key] = deliver

    def ask(self, selector: str, deliver: Any) -> None:
        self.asked.append(selector)

    def announce(self, node: str) -> None:
        self.tokens.append(node)

    def announce_key(self, key: str) -> None:
        self.tokens.append(key)
