"""The proof that the trials can fail: each right that is lacking is BROKEN, each too many OPEN.

Real sessions at a real door, whose rules are spoiled by one.
"""

import socket
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

pytest.importorskip("cryptography")

from reflexarc.securing.door_row import DoorState
from reflexarc.securing.door_under_trial import DoorUnderTrial
from reflexarc.securing.secured_robot import SecuredRobot
from reflexarc.securing.security_folder import make_folder
from reflexarc.securing.variants import settings_of
from support.spoiled_rights import Rights, granted, named, narrowed, revoked, widened

ROBOT = SecuredRobot("robot0", (), 7447, "body", 1.0)


def answering(rights: Rights) -> None:
    """A viewer is asked, and answers."""
    granted("viewer", "runtime is asked", rights)
    granted("viewer", "runtime answers", rights)


def bad(spoil: Callable[[Rights], None], folder_path: Path) -> dict[str, tuple[DoorState, str]]:
    folder = make_folder(folder_path / "keys", ROBOT)
    door = settings_of(folder, "body")
    spoil(door["access_control"])
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    guests = {role: settings_of(folder, role) for role in ROBOT.guests}
    rows = list(DoorUnderTrial(ROBOT, door, guests, port).rows(folder.authority()))
    assert len(rows) == len(ROBOT.guests) + 5
    return {row.door: (row.state, row.words) for row in rows if row.state is not DoorState.SHUT}


@pytest.mark.long
@pytest.mark.parametrize(
    ("spoil", "door", "words"),
    [
        (partial(granted, "viewer", "operator asks"), "who asks", "viewer asks for another"),
        (partial(granted, "recorder", "operator says"), "recorder says nothing", "stop"),
        (partial(widened, "hear", "another/*"), "who hears", "viewer hears of another robot"),
        (partial(widened, "hear", "**"), "who hears", "viewer hears of another robot"),
        (partial(named, ["subscribe", "hear"]), "who hears", "no role, hears"),
        (partial(named, ["ask", "learn"]), "who asks", "nobody learns the policy"),
        (partial(named, ["operator asks"]), "who asks", "nobody asks for another policy"),
        (partial(named, ["look", "see"]), "who lives", "nobody sees who lives"),
        (answering, "who answers", "viewer answers for the policy; viewer takes requests"),
        (partial(granted, "viewer", "runtime lives"), "who lives", "others pass for runtime"),
        (partial(widened, "viewer lives", "robot0/alive/body"), "who lives", "pass for body"),
    ],
)
def test_a_right_too_many_is_open(
    spoil: Callable[[Rights], None], door: str, words: str, tmp_path: Path
):
    found = bad(spoil, tmp_path)
    assert found[door][0] is DoorState.OPEN
    assert words in found[door][1]


@pytest.mark.long
@pytest.mark.parametrize(
    ("spoil", "door", "words"),
    [
        (partial(revoked, "operator asks"), "who asks", "operator cannot ask for another policy"),
        (partial(revoked, "operator learns"), "who asks", "operator is not answered"),
        (partial(revoked, "learn"), "who asks", "viewer does not learn the policy"),
        (partial(revoked, "hear"), "who hears", "viewer does not hear arm, body, command"),
        (partial(revoked, "subscribe"), "who hears", "runtime does not hear arm, body, command"),
        (partial(narrowed, "hear", "robot0/stop"), "who hears", "runtime does not hear stop"),
        (partial(revoked, "runtime says"), "runtime says what it may", "was not heard on command"),
        (
            partial(revoked, "runtime is heard"),
            "runtime says what it may",
            "was not heard on",
        ),
        (partial(revoked, "runtime answers"), "who answers", "runtime is not heard when it answ"),
        (partial(revoked, "runtime is asked"), "who answers", "runtime is not heard when it takes"),
        (partial(revoked, "viewer lives"), "who lives", "viewer is not seen to live"),
        (partial(revoked, "see"), "who lives", "operator does not see who lives"),
    ],
)
def test_a_right_that_is_lacking_is_broken(
    spoil: Callable[[Rights], None], door: str, words: str, tmp_path: Path
):
    """Without the rule `hear`, for one, the robot is deaf and every listener proves nothing."""
    found = bad(spoil, tmp_path)
    assert found[door][0] is DoorState.BROKEN
    assert words in found[door][1]


@pytest.mark.long
def test_the_rights_that_init_writes_are_neither(tmp_path: Path):
    assert bad(lambda rights: None, tmp_path) == {}
