"""Does once, before the first tick, whatever a tick may do for the first time.

Libraries import modules and open files when they are first used. In the loop that takes time, and
where no file can be opened it fails; so it happens here. Nothing of it is sent or recorded.
"""

import contextlib

import numpy as np

from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.decision import Timing
from reflexarc_runtime.loop.cadence.monitor import Monitor
from reflexarc_runtime.messages.codec import Status, encode_command, encode_status, encode_tick
from reflexarc_runtime.messages.controls import encode_overrun, encode_stop
from reflexarc_runtime.messages.topics import OVERRUN, RESET, STOP
from reflexarc_runtime.messages.wire import Message, Stamp, protobuf_encoding
from reflexarc_runtime.sensing.senses import Sensed
from reflexarc_runtime.serving.swapping import AnyController

_NO_TIME = Timing(0, 0, 0, 0, 0, 0)


def warm_up(controller: AnyController) -> None:
    """Decide, judge good and bad messages, encode one of each message, compute percentiles."""
    with contextlib.suppress(Exception):  # what fails here has its verdict in the loop
        decide_on_darkness(controller)
        _guard_darkness(controller)
    topics = (controller.sense.topic, OVERRUN, RESET, STOP)
    bad = tuple(Message(topic.name, b"\xff", "", b"", 0) for topic in topics)
    controls = (
        _message(OVERRUN.name, encode_overrun(0, 0), OVERRUN.schema),
        _message(RESET.name, b"", RESET.schema),
        _message(STOP.name, encode_stop("warm-up"), STOP.schema),
    )
    monitor = Monitor()
    for messages in ((), bad, controls):
        _, decision = controller.step(State(), Inputs(messages, 0), 0)
        encode_tick(decision, _NO_TIME)
        encode_command(decision.command)
        monitor.saw(decision, _NO_TIME)
    period = monitor.period()
    verdicts, phases = tuple(period.verdicts.items()), tuple(period.phases.items())
    encode_status(Status("", verdicts=verdicts, phases=phases))


def decide_on_darkness(controller: AnyController) -> None:
    """Ask its policy about darkness, as it has never been asked before."""
    contract = controller.contract
    stack = np.zeros((1, *contract.retina.stack_shape), np.uint8)
    if contract.state.size:
        memory = np.array([contract.state.start_value], np.float32)
        controller.policy.decide(stack, memory)  # type: ignore[call-arg]  # it has a memory
    else:
        controller.policy.decide(stack)  # type: ignore[call-arg]  # it has none


def _guard_darkness(controller: AnyController) -> None:
    """Let the guard work out what it can; the angles of a scan are not known before the first."""
    retina = np.zeros(controller.contract.retina.shape, np.uint8)
    beams = controller.sense.beams(Sensed(Stamp(0, 0), 0, retina))
    if controller.guard is not None and beams is not None:
        controller.guard.prepare(beams.fan)


def _message(name: str, payload: bytes, schema: str) -> Message:
    return Message(name, payload, protobuf_encoding(schema), b"", 0)
