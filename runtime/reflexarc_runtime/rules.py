"""Versions of the controller's rules: a log is replayed by those under which it was recorded.

Whatever changes what the controller does with the same messages is a new version here, and the old
one stays. What a contract says (holds, margins, memory) is no rule: older contracts have none.
"""

from dataclasses import dataclass

from reflexarc_runtime.errors import LogError


@dataclass(frozen=True, slots=True)
class ControllerRules:
    """What the controller does, where versions differ."""

    version: int
    stop_is_a_message: bool
    """A stop comes through the inbox, counts as an input, and holds until a reset comes. Before, it
    came beside the inputs, and ended the run."""

    one_source: bool
    """The loop is bound to one body; its commands echo that body's identifier. Before, whoever
    sent a fitting message was believed."""

    checked_senses: bool
    """A retina says which eye made it; a scan is turned as its scanner sits, and what lies too near
    to be measured, or is unknown, is no free way. Before, numbers were taken as they came."""

    ages_backlogs: bool
    """An input is as old as it waited since its arrival and before it: see `backlog`. Before, age
    counted from the arrival alone."""

    recovers_after_overrun: bool
    """Good inputs count anew behind a late tick. Before, those that came during it counted, and the
    loop could drive on without a verdict RECOVERING."""

    knows_ended_decisions: bool
    """A new policy is rolled back where an `Overrun` says that its decision was ended. Before, one
    that had not answered at an overrun was taken to hang if it would have been asked."""

    calls_off_swap_to_former: bool
    """A roll-back calls off the swap to the policy that it brings back. Before, that policy took
    over from itself at the next standstill."""


def _of(version: int) -> ControllerRules:
    """What a version does: each thing since the version that brought it."""
    return ControllerRules(
        version,
        stop_is_a_message=version >= 2,
        one_source=version >= 3,
        checked_senses=version >= 4,
        ages_backlogs=version >= 4,
        recovers_after_overrun=version >= 4,
        knows_ended_decisions=version >= 5,
        calls_off_swap_to_former=version >= 5,
    )


RULES = {version: _of(version) for version in (1, 2, 3, 4, 5)}
CURRENT_RULES = RULES[5]


def rules_of(version: int) -> ControllerRules:
    """The rules of a version.

    Raises:
        LogError: a version that this package does not know.
    """
    if version not in RULES:
        raise LogError(
            f"rules of the controller: expected a version from 1 to {max(RULES)}, got {version}; "
            "upgrade reflexarc on this machine if they are newer"
        )
    return RULES[version]
