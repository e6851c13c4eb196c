"""What is found at the door of a robot in use, whose settings need not be those of the folder."""

import socket
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

pytest.importorskip("cryptography")

from reflexarc.securing.door_in_use import GIBBERISH, HARMLESS, rows_in_use
from reflexarc.securing.door_row import DoorState
from reflexarc.securing.secured_robot import SecuredRobot
from reflexarc.securing.security_folder import make_folder
from reflexarc.securing.variants import listening, session, settings_of
from reflexarc_runtime.messages.controls import is_reset
from reflexarc_runtime.messages.topics import RESET, STOP, Topic
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_sim_bridge.body.gate.reading import fault_of_operator, read_command
from reflexarc_sim_bridge.body.gate.refusal import Refusal
from support.spoiled_rights import Rights, granted, revoked

ROBOT = SecuredRobot("robot0", (), 7447, "body", 1.0)
SWAP = "who asks for another policy"


def found(
    spoil: Callable[[Rights], None],
    folder_path: Path,
    *,
    answers: bool = True,
    roles: tuple[str, ...] = ROBOT.guests,
) -> dict[str, tuple[DoorState, str]]:
    """Of those whose files are here: the worst row of each door."""
    folder = make_folder(folder_path / "keys", ROBOT)
    door = settings_of(folder, "body")
    spoil(door["access_control"])
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with session("robot0", listening(door, port)) as host:
        if answers:
            host.take_requests(lambda request, answer: answer(b"refused"))
        settings = {role: settings_of(folder, role) for role in roles}
        rows = list(rows_in_use("robot0", settings, f"tls/127.0.0.1:{port}"))
    worst_last = sorted(rows, key=lambda row: row.is_bad)
    return {row.door: (row.state, row.words) for row in worst_last}


@pytest.mark.long
def test_the_rights_that_init_writes_are_shut(tmp_path: Path):
    rows = found(lambda rights: None, tmp_path)
    assert {state for state, _ in rows.values()} == {DoorState.SHUT}
    assert rows["operator at the robot in use"][1] == (
        "heard on arm, hold_to_run, release, reset; silent on command"
    )
    assert rows[SWAP][1] == "operator alone is answered"


def may_swap(rights: Rights) -> None:
    """A viewer asks, and learns the answer."""
    granted("viewer", "operator asks", rights)
    granted("viewer", "operator learns", rights)


@pytest.mark.long
@pytest.mark.parametrize(
    ("spoil", "door", "words"),
    [
        (partial(granted, "viewer", "operator says"), "viewer at the robot in use", "arm, hold_to"),
        (may_swap, SWAP, "viewer is answered"),
    ],
)
def test_a_right_too_many_is_open(
    spoil: Callable[[Rights], None], door: str, words: str, tmp_path: Path
):
    state, said = found(spoil, tmp_path)[door]
    assert state is DoorState.OPEN
    assert words in said


@pytest.mark.long
def test_a_listener_that_is_deaf_proves_nothing(tmp_path: Path):
    rows = found(partial(revoked, "hear"), tmp_path, answers=False)
    assert rows["operator at the robot in use"][0] is DoorState.BROKEN
    assert "proves nothing" in rows["viewer at the robot in use"][1]
    assert rows[SWAP] == (DoorState.UNTRIED, "a runtime answers nobody here: does one run?")


@pytest.mark.long
def test_files_of_a_part_of_the_roles_prove_a_part(tmp_path: Path):
    rows = found(lambda rights: None, tmp_path, roles=("recorder", "viewer"))
    assert rows["viewer at the robot in use"][0] is DoorState.UNTRIED
    alone = found(lambda rights: None, tmp_path / "2", roles=("viewer",))
    assert alone["who moves the robot"][0] is DoorState.UNTRIED


@pytest.mark.parametrize("topic", HARMLESS, ids=lambda topic: topic.name)
def test_what_is_said_to_a_robot_in_use_does_nothing(topic: Topic):
    """By the readers of body and runtime; a stop would count in any form, and is not among them."""
    assert topic is not STOP
    stamp = pack_stamp(Stamp(0, 0, b"somebody who asks"[:16]))
    said = Message(topic.key("robot0"), GIBBERISH, protobuf_encoding(topic.schema), stamp, 0)
    if topic.name == "command":
        assert read_command(said) is Refusal.UNREADABLE
    else:
        assert fault_of_operator(topic, said) is Refusal.UNREADABLE
    assert topic is not RESET or not is_reset(said)
