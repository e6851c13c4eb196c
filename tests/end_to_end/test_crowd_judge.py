"""The judge of the crowd can fail: each of its questions, by hand-made evidence."""

from support.crowd_judge import MS, Evidence, Step, alternations, idle, moved_by_others

BODY, FAST, SLOW = b"body", b"fast", b"slow"
S = 1000 * MS


def evidence(speeds: list[float], holder: bytes = FAST) -> Evidence:
    """A body with one step each 20 ms, beside two runtimes of 1 and 0.5 m/s that both command."""
    times = [n * 20 * MS for n in range(len(speeds))]
    return Evidence(
        steps={BODY: [Step(t, v) for t, v in zip(times, speeds, strict=True)]},
        leases={BODY: [(0, holder)]},
        speeds={FAST: 1.0, SLOW: 0.5},
        commands={who: [(t, BODY) for t in times] for who in (FAST, SLOW)},
    )


def test_a_body_that_only_its_holder_moves_is_in_order():
    heard = evidence(50 * [1.0])
    assert not moved_by_others(heard)
    assert not alternations(heard)


def test_two_runtimes_that_move_one_body_at_a_time_are_reported():
    heard = evidence(25 * [1.0, 0.5])
    assert len(moved_by_others(heard)) == 25
    assert len(alternations(heard)) == 49


def test_a_body_that_moves_while_nobody_holds_it_is_reported():
    assert len(moved_by_others(evidence(10 * [1.0], holder=b""))) == 10


def test_a_hand_over_is_no_alternation():
    heard = evidence(25 * [1.0] + 25 * [0.5])
    heard.leases[BODY].append((500 * MS, SLOW))
    assert not moved_by_others(heard)
    assert not alternations(heard)


def test_an_idle_pair_is_reported_unless_the_machine_slept():
    heard = evidence(50 * [1.0] + 50 * [0.0] + 50 * [1.0])
    lives = {BODY: [(0, 3 * S)], FAST: [(0, 3 * S)]}
    found, excused, judged_ns = idle(heard, lives)
    assert (len(found), excused, judged_ns) == (1, 0, 2500 * MS)
    found, excused, _ = idle(heard, lives, [(980 * MS, 1990 * MS)])
    assert (found, excused) == ([], 1)


def test_beside_a_second_body_a_robot_may_stand():
    heard = evidence(150 * [0.0])
    heard.steps[b"other"] = []
    lives = {who: [(0, 3 * S)] for who in (BODY, b"other", FAST)}
    assert idle(heard, lives) == ([], 0, 0)
