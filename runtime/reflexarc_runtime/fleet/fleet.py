"""Every robot on a bus: what was heard of it, remembered within bounds.

Pure: messages and times are passed in, and all times are the listener's own, so that no clock of
any robot matters. Names and nodes that are heard stay; for new ones there is room as long as there
is, or where others have fallen silent. So a flood of names displaces no robot that is there.
"""

import re
from dataclasses import dataclass, field
from typing import TypeVar

from reflexarc_runtime.fleet.nodes import GONE_NS, SILENT_NS, BodyHeard, RuntimeHeard
from reflexarc_runtime.fleet.reading import MOST_NAME, read_word, shown_name
from reflexarc_runtime.fleet.said import RuntimeSaid, Word
from reflexarc_runtime.fleet.views import BodyView, FleetView, RobotView, RuntimeView
from reflexarc_runtime.messages.wire import Message, UndecodableError

MOST_ROBOTS = 256
MOST_ALIKE = 8
"""Runtimes, or bodies, of one robot."""
MOST_TOKENS = 8
"""Nodes of one robot that announce themselves."""

_Node = TypeVar("_Node", RuntimeHeard, BodyHeard)


@dataclass
class RobotHeard:
    """All that was heard of one name."""

    heard_ns: int
    runtimes: dict[bytes, RuntimeHeard] = field(default_factory=dict)
    bodies: dict[bytes, BodyHeard] = field(default_factory=dict)
    tokens: set[str] = field(default_factory=set)

    def last_ns(self) -> int:
        """When anything was heard of it last."""
        runtimes = (each.heard_ns for each in self.runtimes.values())
        bodies = (each.heard_ns for each in self.bodies.values())
        return max([self.heard_ns, *runtimes, *bodies])


class Fleet:
    """What one listener knows of all robots."""

    def __init__(self) -> None:
        self._robots: dict[str, RobotHeard] = {}
        self._unreadable = 0
        self._left_out = 0
        self._full_until_ns = -SILENT_NS

    def hear(self, message: Message) -> bool:
        """Take one message from `*/status` or `*/lease`; whether a node is new by it."""
        try:
            word = read_word(message)
        except UndecodableError:
            self._unreadable += 1
            return False
        robot = self._robot(word.robot, word.heard_ns)
        if robot is None:
            self._left_out += 1
            return False
        return self._take(robot, word)

    def announced(self, key: str, now_ns: int, *, is_there: bool) -> bool:
        """Take note of a liveliness token that came or went; whether it is new."""
        name, _, node = key.partition("/alive/")
        robot = self._robot(shown_name(name), now_ns) if is_there else None
        robot = robot or self._robots.get(shown_name(name))
        node = shown_name(node)[:MOST_NAME]
        if robot is None:
            self._left_out += is_there
            return False
        was_there = node in robot.tokens
        if not is_there:
            robot.tokens.discard(node)
        elif len(robot.tokens) < MOST_TOKENS:
            robot.tokens.add(node)
        return is_there and not was_there

    def view(self, now_ns: int) -> FleetView:
        """The fleet now, without those who are long silent."""
        self._forget(now_ns)
        names = sorted(self._robots, key=_natural)
        robots = tuple(_robot_view(name, self._robots[name], now_ns) for name in names)
        return FleetView(robots, self._unreadable, self._left_out)

    def _take(self, robot: RobotHeard, word: Word) -> bool:
        said, at_ns = word.said, word.heard_ns
        if isinstance(said, RuntimeSaid):
            return self._take_runtime(robot, word.sender, said, at_ns)
        body = robot.bodies.get(word.sender)
        is_new = body is None
        if body is None:
            body = BodyHeard(at_ns)
            if not self._placed(robot.bodies, word.sender, body, at_ns):
                return False
        body.hear(said, at_ns)
        return is_new

    def _take_runtime(
        self, robot: RobotHeard, sender: bytes, said: RuntimeSaid, at_ns: int
    ) -> bool:
        known = robot.runtimes.get(sender)
        if known is not None:
            known.hear(said, at_ns)
            return False
        fresh = RuntimeHeard(said, at_ns)
        fresh.count()
        return self._placed(robot.runtimes, sender, fresh, at_ns)

    def _placed(self, nodes: dict[bytes, _Node], sender: bytes, node: _Node, now_ns: int) -> bool:
        if len(nodes) >= MOST_ALIKE:
            oldest = min(nodes, key=lambda each: nodes[each].heard_ns)
            if now_ns - nodes[oldest].heard_ns < SILENT_NS:
                self._left_out += 1
                return False
            del nodes[oldest]
        nodes[sender] = node
        return True

    def _robot(self, name: str, now_ns: int) -> RobotHeard | None:
        """The robot of a name, new if need be; None: there is no room for it."""
        if name not in self._robots:
            if len(self._robots) >= MOST_ROBOTS and not self._made_room(now_ns):
                return None
            self._robots[name] = RobotHeard(now_ns)
        return self._robots[name]

    def _made_room(self, now_ns: int) -> bool:
        """Forget who was silent for longest; all are looked at only when that may have changed."""
        if now_ns < self._full_until_ns:
            return False
        oldest = min(self._robots, key=lambda name: self._robots[name].last_ns())
        silent_at_ns = self._robots[oldest].last_ns() + SILENT_NS
        if now_ns < silent_at_ns:
            self._full_until_ns = silent_at_ns
            return False
        del self._robots[oldest]
        return True

    def _forget(self, now_ns: int) -> None:
        """Forget who has been silent for long; whoever still announces itself stays in the list."""
        for robot in self._robots.values():
            _forget_nodes(robot.runtimes, now_ns)
            _forget_nodes(robot.bodies, now_ns)
        empty = [name for name, each in self._robots.items() if _is_gone(each, now_ns)]
        for name in empty:
            del self._robots[name]


def _forget_nodes(nodes: dict[bytes, _Node], now_ns: int) -> None:
    for sender in [s for s, node in nodes.items() if now_ns - node.heard_ns >= GONE_NS]:
        del nodes[sender]


def _is_gone(robot: RobotHeard, now_ns: int) -> bool:
    is_empty = not (robot.runtimes or robot.bodies or robot.tokens)
    return is_empty and now_ns - robot.heard_ns >= SILENT_NS


def _robot_view(name: str, robot: RobotHeard, now_ns: int) -> RobotView:
    leases = [each.lease for each in robot.bodies.values() if now_ns - each.heard_ns < SILENT_NS]
    holders = {lease.holder for lease in leases if lease is not None}
    runtimes = sorted(robot.runtimes.items())
    bodies = sorted(robot.bodies.items())
    return RobotView(
        name,
        tuple(sorted(robot.tokens)),
        tuple(_runtime_view(s, each, now_ns, s in holders) for s, each in runtimes),
        tuple(_body_view(sender, each, now_ns) for sender, each in bodies),
    )


def _runtime_view(sender: bytes, heard: RuntimeHeard, now_ns: int, holds: bool) -> RuntimeView:
    age_ns = max(now_ns - heard.heard_ns, 0)
    return RuntimeView(
        sender,
        heard.said,
        age_ns * 1e-9,
        age_ns >= SILENT_NS,
        holds,
        heard.period_verdicts,
        heard.tallies,
    )


def _body_view(sender: bytes, heard: BodyHeard, now_ns: int) -> BodyView:
    age_ns = max(now_ns - heard.heard_ns, 0)
    return BodyView(sender, heard.said, heard.lease, age_ns * 1e-9, age_ns >= SILENT_NS)


def _natural(name: str) -> tuple[list[tuple[int, int, str]], str]:
    """So that robot2 comes before robot10."""
    parts = re.findall(r"[0-9]+|[^0-9]+", name)
    return [(0, int(p), "") if p.isascii() and p.isdigit() else (1, 0, p) for p in parts], name
