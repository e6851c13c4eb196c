"""The three roles as nodes of a dora dataflow. Runs in an environment with dora-rs, not in ours.

Variants of the brain: `timer` decides at each tick of dora's timer on the last retina; `timer, age
checked` has three lines more; `timer, failures heeded` says stop once dora reports that the sensor
failed; `arrival` decides at each retina.
"""

import numpy as np
import pyarrow as pa
from dora import Node
from roles import Body, Brain, Options, options, send_retinas

MOST_AGE_NS = 100_000_000


def be_sensor(node: Node, told: Options) -> None:
    """Send retinas."""
    send_retinas(lambda payload: node.send_output("retina", _array(payload)), told.period_ns)


def be_brain(node: Node, told: Options) -> None:
    """Decide at a tick, or when a retina comes."""
    brain = Brain(told.folder, MOST_AGE_NS if "age" in told.variant else 0)
    decides_on = "tick" if told.variant.startswith("timer") else "retina"
    for event in node:
        if event["type"] == "NODE_FAILED":
            brain.lost_sensor = "failures" in told.variant
        if event["type"] != "INPUT":
            continue
        if event["id"] == "tick":
            brain.wake()
        else:
            brain.see(event["value"].to_numpy().tobytes())
        command = brain.decide() if event["id"] == decides_on else None
        if command is not None:
            node.send_output("command", _array(command))


def be_body(node: Node, told: Options) -> None:
    """Note each command."""
    body = Body(told.folder)
    for event in node:
        if event["type"] == "INPUT":
            body.hear(event["value"].to_numpy().tobytes())


def _array(payload: bytes) -> pa.Array:
    return pa.array(np.frombuffer(payload, np.uint8))


def main() -> None:
    """Be the role that the command line names, as a node of dora."""
    told = options()
    {"sensor": be_sensor, "brain": be_brain, "body": be_body}[told.role](Node(), told)


if __name__ == "__main__":
    main()
