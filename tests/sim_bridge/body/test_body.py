from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import SAFE_ACTION, Command, Input, Verdict, drive_command
from reflexarc_sim_bridge.body.body import Body
from reflexarc_sim_bridge.worlds.files import world_named

CONTRACT = PolicyContract()
PERIOD_NS = 20_000_000


def moved_m(command: Command, steps: int = 3) -> float:
    """How far a body goes that hears one command and then lives for some steps."""
    body = Body(world_named("reference-1"), CONTRACT, 50.0, seed=0)
    begin_m = body.place.x_m
    body.hear(command)
    for step in range(1, steps + 1):
        body.move(step * PERIOD_NS)
    return body.place.x_m - begin_m


def test_a_drive_command_moves_the_body_ahead():
    command = drive_command(0, 0, CONTRACT.actions[0], Input(0, 0, 0, 0), 10 * PERIOD_NS)
    assert moved_m(command) > 0.05


def test_a_drive_command_moves_it_no_longer_than_it_is_valid():
    command = drive_command(0, 0, CONTRACT.actions[0], Input(0, 0, 0, 0), 3 * PERIOD_NS)
    assert moved_m(command, steps=20) == moved_m(command, steps=2) > 0.0


def test_a_command_without_an_echo_moves_nothing_whatever_speeds_it_names():
    for verdict in Verdict:
        assert moved_m(Command(0, SAFE_ACTION, verdict, 1.0, 0.0, 0.0)) == 0.0


def test_a_contact_is_said_to_be_where_it_began_and_not_where_the_body_goes_on():
    body = Body(world_named("reference-1"), CONTRACT, 50.0, seed=0)
    for step in range(1, 2000):
        body.hear(
            drive_command(
                0,
                step * PERIOD_NS,
                CONTRACT.actions[0],
                Input(step, step * PERIOD_NS, 0, 0),
                10 * PERIOD_NS,
            )
        )
        before = body.place
        met = body.move(step * PERIOD_NS)
        if met is not None:
            assert (met.y_m, met.heading_rad) == (before.y_m, before.heading_rad)
            assert before.x_m <= met.x_m == body.place.x_m
            assert body.place.y_m != met.y_m
            return
    raise AssertionError("it drove 40 m through a quarter-covered field without a contact")
