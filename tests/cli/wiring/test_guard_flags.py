"""The flags of the guard: ranges of a topic of their own, and where there can be none."""

import pytest

from reflexarc.wiring.guard_flags import GuardFlags
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import UsageError

OWN = GuardFlags(guard_ranges="scan", guard_ranges_oldest_s=0.4)


def test_the_topic_of_the_ranges_is_among_the_settings_that_a_log_carries():
    settings = OWN.settings_for(PolicyContract())
    assert settings is not None
    assert (settings.ranges, settings.ranges_oldest_s) == ("scan", 0.4)
    OWN.check("retina", lockstep=False)
    GuardFlags().check("scan", lockstep=True)
    GuardFlags(no_guard=True).check("retina", lockstep=True)


@pytest.mark.parametrize(
    ("flags", "sensor", "lockstep", "words"),
    [
        (OWN, "scan", False, "the input is the scan already"),
        (OWN, "retina", True, "not in lockstep"),
        (GuardFlags(no_guard=True, guard_ranges="scan"), "retina", False, "--no-guard"),
    ],
)
def test_ranges_for_nobody_are_refused(flags, sensor, lockstep, words):
    with pytest.raises(UsageError, match=words):
        flags.check(sensor, lockstep=lockstep)


@pytest.mark.parametrize("oldest_s", [0.0, -1.0, 11.0, float("nan")])
def test_an_age_that_is_none_is_refused(oldest_s):
    with pytest.raises(UsageError, match=r"guard\.ranges_oldest_s"):
        GuardFlags(guard_ranges_oldest_s=oldest_s).settings_for(PolicyContract())
