"""Commands that were sent, matched with the ticks that decided them."""

from hypothesis import given
from hypothesis import strategies as st

from reflexarc_logs.replaying.report import CommandsResult
from reflexarc_logs.replaying.sent_commands import REACH, SentCommands
from reflexarc_runtime.messages_pb2 import Command, Decision

LOOP, STRANGER = b"the loop's own..", b"somebody else..."


def command(number: int, speed_mps: float = 1.0) -> Command:
    return Command(sequence=number, verdict="OK", linear_mps=speed_mps)


def tick(number: int) -> Decision:
    return Decision(index=number, command=command(number))


def listened(events: list[tuple[str, int]]) -> CommandsResult:
    """What a listener finds who hears these ticks and commands in this order."""
    sent = SentCommands("robot0", by_loop=False)
    for kind, number in events:
        if kind == "tick":
            sent.told(tick(number), LOOP)
        elif kind == "stranger":
            sent.sent(command(number, 9.0).SerializeToString(), STRANGER, 0)
        else:
            speed_mps = 1.0 if kind == "command" else 9.0
            sent.sent(command(number, speed_mps).SerializeToString(), LOOP, 0)
    return sent.result()


numbers = st.sets(st.integers(0, 30), max_size=12)


@given(ticks=numbers, right=numbers, strange=numbers, dice=st.randoms(use_true_random=False))
def test_in_any_order_each_command_finds_its_tick(ticks, right, strange, dice):
    events = [
        *(("tick", number) for number in ticks),
        *(("command" if number % 3 else "wrong", number) for number in right),
        *(("stranger", number) for number in strange),
    ]
    dice.shuffle(events)
    found = listened(events)
    both = ticks & right
    assert found.compared == len(both)
    assert found.identical == sum(1 for number in both if number % 3)
    assert found.ticks_without == len(ticks - right)
    assert (found.recorded, found.without_tick + found.of_others) == (
        len(right) + len(strange),
        len(right - ticks) + len(strange),
    )


def test_what_waits_for_its_other_half_is_bounded():
    sent = SentCommands("robot0", by_loop=True)
    for number in range(REACH + 10):
        sent.told(tick(number), LOOP)
    sent.sent(command(0).SerializeToString(), LOOP, 0)
    sent.sent(command(REACH).SerializeToString(), LOOP, REACH)
    found = sent.result()
    assert (found.compared, found.without_tick) == (1, 1)
    assert found.ticks_without == REACH + 9


def test_a_wrong_number_in_a_loops_own_command_is_a_difference():
    sent = SentCommands("robot0", by_loop=True)
    sent.told(tick(7), LOOP)
    sent.sent(command(8).SerializeToString(), LOOP, 7)
    found = sent.result()
    assert found.first is not None
    assert (found.first.tick, found.first.path) == (7, "sent.sequence")
