"""The ticks of a log as rows of a table: one row a tick, in the order of the log.

Times are nanoseconds, lengths metres, angles radians counter-clockwise. A field that a tick does
not have is None: the Q-values where the policy was not asked, the pose before the first one came.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from reflexarc_logs.reading.reader import Log, decode
from reflexarc_logs.replaying.message_fields import message_type
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import NO_WINNER, SAFE_ACTION, Verdict
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import CONTACT, POSE, TICK
from reflexarc_runtime.messages_pb2 import Tick
from reflexarc_runtime.policy.policy import load_contract

Kind: TypeAlias = Literal["uint", "int", "float", "float32", "text", "bytes", "floats"]
Row: TypeAlias = list[Any]
"""One value for each column."""

SAFE_NAME = "safe"
"""Of the safe command, which is none of the contract's actions."""

_COLUMNS: tuple[tuple[str, Kind], ...] = (
    ("tick", "uint"),
    ("slot", "uint"),
    ("time_ns", "uint"),
    ("now_ns", "int"),
    ("verdict", "text"),
    ("reason", "text"),
    ("action", "int"),
    ("action_name", "text"),
    ("winner", "int"),
    ("linear_mps", "float"),
    ("lateral_mps", "float"),
    ("angular_radps", "float"),
    ("valid_for_ns", "int"),
    ("inputs", "int"),
    ("input_sequence", "uint"),
    ("input_time_ns", "int"),
    ("input_age_ns", "int"),
    ("lateness_ns", "int"),
    ("decide_ns", "int"),
    ("x_m", "float"),
    ("y_m", "float"),
    ("heading_rad", "float"),
    ("contacts", "int"),
    ("retina", "bytes"),
    ("memory", "floats"),
)


@dataclass(frozen=True)
class Column:
    """A column of the table."""

    name: str
    kind: Kind


class TickTable:
    """The ticks of one log.

    Args:
        log: the log; it holds ticks.

    Raises:
        LogError: it holds none, or cannot be read.
        PolicyError, ContractError: the attached policy is not intact.
    """

    def __init__(self, log: Log) -> None:
        self._log = log
        self._has_winner = _has_winner(log)
        self.contract = None if log.policy is None else load_contract(log.policy, bounds=None)
        self._names = _action_names(log, self.contract)
        q_values = tuple(Column(f"q_{name}", "float32") for name in self._names)
        self.columns = (*(Column(*column) for column in _COLUMNS), *q_values)

    def rows(self) -> Iterator[Row]:
        """Every tick; the pose and the contacts are the newest before it in the log.

        Raises:
            LogError: the log cannot be read, or a tick has other Q-values than the first one.
        """
        log = self._log
        tick_topic, pose_topic, contact = (log.topic(t.name) for t in (TICK, POSE, CONTACT))
        place: Row = [None, None, None]
        contacts = 0
        for record in log.records(tick_topic, pose_topic, contact):
            if record.topic == tick_topic:
                tick = decode(log, record, Tick)
                yield self._row(tick, record.log_ns, [*place, contacts])
            elif record.topic == pose_topic:
                place = _place(decode(log, record, PoseInFrame))
            else:
                contacts += 1

    def _row(self, tick: Tick, log_ns: int, around: Row) -> Row:
        decision, timing = tick.decision, tick.timing
        command = decision.command
        used = decision.input if decision.HasField("input") else None
        return [
            decision.index,
            decision.slot,
            log_ns,
            decision.now_ns,
            _verdict_name(decision.verdict),
            decision.reason,
            decision.action,
            self._name(decision.action),
            self._winner(decision.winner),
            command.linear_mps,
            command.lateral_mps,
            command.angular_radps,
            command.valid_for_ns,
            decision.inputs,
            None if used is None else used.sequence,
            None if used is None else used.source_time_ns,
            None if used is None else used.age_ns,
            timing.lateness_ns,
            timing.decide_ns,
            *around,
            decision.retina or None,
            list(decision.state) or None,
            *self._q_values(decision.index, list(decision.q_values)),
        ]

    def _q_values(self, index: int, q_values: list[float]) -> list[float | None]:
        if not q_values:
            return [None] * len(self._names)
        if len(q_values) != len(self._names):
            raise LogError(
                f"{self._log.path}: tick {index}: expected {len(self._names)} Q-values, got "
                f"{len(q_values)}; several policies do not fit one table"
            )
        return [*q_values]

    def _winner(self, winner: int) -> int | None:
        return winner if self._has_winner and winner != NO_WINNER else None

    def _name(self, action: int) -> str | None:
        if action == SAFE_ACTION:
            return SAFE_NAME
        return self._names[action] if 0 <= action < len(self._names) else None


def _has_winner(log: Log) -> bool:
    """Whether ticks say what the policy preferred: they did not in the first logs."""
    return "winner" in message_type(log.tick_descriptor(), "decision").fields_by_name


def _action_names(log: Log, contract: PolicyContract | None) -> tuple[str, ...]:
    """The names of the actions; numbers, as many as the first tick has, without a policy."""
    if contract is not None:
        return tuple(action.name for action in contract.actions)
    counts = (len(tick.decision.q_values) for tick in log.ticks())
    return tuple(map(str, range(next(filter(None, counts), 0))))


def _verdict_name(number: int) -> str:
    """Its name; of one that a newer version has, its number."""
    try:
        return Verdict(number).name
    except ValueError:
        return str(number)


def _place(message: PoseInFrame) -> Row:
    position, turn = message.pose.position, message.pose.orientation
    return [position.x, position.y, math.remainder(2.0 * math.atan2(turn.z, turn.w), math.tau)]
