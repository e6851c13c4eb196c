"""A keyframe holds all that the controller remembers: what follows is decided the same."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.choice import Hold
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.keyframe import decode_state, encode_state
from reflexarc_runtime.messages_pb2 import Keyframe
from reflexarc_runtime.sensing.senses import RetinaSense
from support.policies import AddingPolicy
from support.sensing import MS, retina_message

CONTRACT = PolicyContract(
    retina=RetinaSpec(rays=4, frames=3),
    state=StateSpec(1, (0.25,)),
    hold_s=0.06,
    margin=0.1,
)
PERIOD_NS = 20 * MS


def again(state: State) -> State:
    return decode_state(Keyframe.FromString(encode_state(state, "hash")), CONTRACT)


def batch_of(event: str, slot: int):
    message = retina_message(slot, slot * PERIOD_NS, value=slot % 7)
    known = {
        "seen": (message,),
        "none": (),
        "broken": (replace(message, payload=b"\xff"),),
        "stop": (replace(message, key="robot0/stop", payload=b""),),
        "reset": (replace(message, key="robot0/reset", payload=b""),),
    }
    return known[event]


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.sampled_from(["seen"] * 6 + ["none", "broken", "stop", "reset"]), max_size=40),
    st.integers(0, 39),
)
def test_a_controller_goes_on_from_its_keyframe_as_if_nothing_had_been(events, at):
    controller = Controller(AddingPolicy(), CONTRACT, RetinaSense(CONTRACT.retina), "hash")
    through = restored = State()
    for slot, event in enumerate(events):
        if slot == at:
            restored = again(through)
        inputs, now_ns = Inputs(batch_of(event, slot), slot), slot * PERIOD_NS + MS
        through, expected = controller.step(through, inputs, now_ns)
        if slot >= at:
            restored, decision = controller.step(restored, inputs, now_ns)
            assert decision == expected
            assert encode_state(restored, "hash") == encode_state(through, "hash")


def test_every_field_of_a_state_survives():
    state = State(
        index=9,
        streak=4,
        newest=None,
        frames=(),
        fault="broken",
        memory=np.array([[1.5]], np.float32),
        following=np.array([[2.5]], np.float32),
        hold=Hold(2, 7),
        stopped="because",
    )
    restored = again(state)
    assert restored.memory is not None
    assert restored.following is not None
    assert (restored.memory[0, 0], restored.following[0, 0]) == (1.5, 2.5)
    plain = replace(restored, memory=None, following=None)
    assert plain == replace(state, memory=None, following=None)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"frames": [b"1234"]}, "frames: expected 3"),
        ({"frames": [b"12345"] * 3}, "bytes of a retina: expected 4, got 5"),
        ({"newest": {"sequence": 1}}, "frames: expected some"),
        ({"memory": {"next": [1.0, 2.0]}}, "values of a memory: expected 1, got 2"),
        ({"hold": {"action": 3}}, "a held action: expected 0 to 2, got 3"),
    ],
)
def test_a_keyframe_of_another_policy_is_refused_in_one_line(change, words):
    with pytest.raises(LogError, match=words):
        decode_state(Keyframe(**change), CONTRACT)
