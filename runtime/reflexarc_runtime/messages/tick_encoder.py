"""Encodes one tick after the other into the same message: the loop's own way to `encode_tick`.

Most of what a tick costs to encode is making its message with the four inside it. Here they are
made once, and every field is set anew at every tick. The bytes are those of `encode_tick`.

Protobuf frees nothing of what a message was given as long as the message lives, not even what was
replaced: so they are made anew before long.
"""

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.decision import Command, Decision, Input, Timing
from reflexarc_runtime.messages.codec import to_us

MOST_BYTES = 1 << 16
"""Encoded before the messages are made anew: some hundred ticks."""


class TickEncoder:
    """Encodes ticks; for one thread."""

    def __init__(self) -> None:
        self._begin()

    def _begin(self) -> None:
        self._tick, self._bytes = pb.Tick(), 0
        self._decision, self._timing = self._tick.decision, self._tick.timing
        self._command, self._input = self._decision.command, self._decision.input

    def encode(self, decision: Decision, timing: Timing) -> bytes:
        """A tick as `reflexarc.Tick`."""
        if self._bytes >= MOST_BYTES:
            self._begin()
        self._set_decision(decision)
        self._set_input(decision.input)
        self._set_command(decision.command)
        self._set_timing(timing)
        encoded = self._tick.SerializeToString()
        self._bytes += len(encoded)
        return encoded

    def _set_decision(self, decision: Decision) -> None:
        message = self._decision
        message.index = decision.index
        message.slot = decision.slot
        message.now_ns = decision.now_ns
        message.inputs = decision.inputs
        message.retina = decision.retina
        message.q_values[:] = decision.q_values
        message.action = decision.action
        message.verdict = int(decision.verdict)  # type: ignore[assignment]  # the stub's own enum
        message.reason = decision.reason
        message.policy_hash = decision.policy_hash
        message.winner = decision.winner
        message.state[:] = decision.state

    def _set_input(self, used: Input | None) -> None:
        if used is None:
            self._decision.ClearField("input")
            self._input = self._decision.input  # what was cleared belongs to it no more
            return
        message = self._input
        message.SetInParent()  # numbers that are 0 say nothing by themselves
        message.sequence = used.sequence
        message.source_time_ns = used.source_time_ns
        message.received_ns = used.received_ns
        message.age_ns = used.age_ns

    def _set_timing(self, timing: Timing) -> None:
        message = self._timing
        message.SetInParent()
        message.lateness_ns = timing.lateness_ns
        message.receive_ns = timing.receive_ns
        message.decide_ns = to_us(timing.decide_ns)
        message.publish_ns = to_us(timing.publish_ns)
        message.record_ns = to_us(timing.record_ns)

    def _set_command(self, command: Command) -> None:
        message = self._command
        message.SetInParent()
        message.sequence = command.sequence
        message.action = command.action
        message.verdict = int(command.verdict)  # type: ignore[assignment]  # the stub's own enum
        message.linear_mps = command.linear_mps
        message.lateral_mps = command.lateral_mps
        message.angular_radps = command.angular_radps
        message.valid_for_ns = command.valid_for_ns
        message.body = command.body
        if command.source_sequence is None:
            message.ClearField("source_sequence")
        else:
            message.source_sequence = command.source_sequence
        if command.source_time_ns is None:
            message.ClearField("source_time_ns")
        else:
            message.source_time_ns = command.source_time_ns
