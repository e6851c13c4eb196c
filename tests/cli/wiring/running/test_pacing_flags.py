import pytest

from reflexarc.wiring.running.pacing_flags import PacingFlags
from reflexarc.wiring.watching import Watching
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.pacing.input_pacer import InputPacer
from reflexarc_runtime.loop.pacing.lockstep_pacer import LockstepPacer
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from reflexarc_runtime.messages.topics import RETINA
from support.policies import SMALL


def test_a_pace_is_the_pacer_of_its_name():
    kinds = {"rate": RatePacer, "input": InputPacer}
    for pace, kind in kinds.items():
        flags = PacingFlags(pace)  # type: ignore[arg-type]  # a key of the table above
        assert type(flags.pacer(SMALL, Inbox(), RETINA, lambda: None, lockstep=False)) is kind
        assert flags.name(lockstep=False) == pace
    in_lockstep = PacingFlags()
    pacer = in_lockstep.pacer(SMALL, Inbox(), RETINA, lambda: None, lockstep=True)
    assert type(pacer) is LockstepPacer
    assert in_lockstep.name(lockstep=True) == "lockstep"


@pytest.mark.parametrize(
    ("flags", "lockstep", "words"),
    [
        (PacingFlags(spin_us=-1), False, "--spin-us: expected 0 to 1000, got -1"),
        (PacingFlags(spin_us=1001), False, "got 1001"),
        (PacingFlags("input"), True, "not with --lockstep"),
        (PacingFlags(spin_us=50), True, "not with --lockstep"),
    ],
)
def test_a_pace_that_cannot_be_is_refused(flags: PacingFlags, lockstep: bool, words: str):
    with pytest.raises(UsageError, match=words):
        flags.check(lockstep=lockstep)


def test_the_watchdog_bears_with_the_longest_wait_between_two_inputs():
    watching = Watching(watchdog_ms=5)
    by_rate = watching.budget(SMALL, PacingFlags("rate").longest_wait_periods)
    by_input = watching.budget(SMALL, PacingFlags("input").longest_wait_periods)
    assert (by_rate.period_ns, by_input.period_ns) == (20_000_000, 40_000_000)
    assert by_rate.tick_ns == by_input.tick_ns
    assert round(by_input.process_s - by_rate.process_s, 6) == 0.02
