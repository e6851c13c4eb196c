"""Does a policy fit a body? That with which it learned may be no smaller, quicker or prompter."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from reflexarc_runtime.errors import ContractError

if TYPE_CHECKING:  # a command line shall not load a contract to show its flags
    from reflexarc_runtime.contract.body_spec import BodySpec

FLAG = "--allow-body"

_SLACK = 1e-9


def check_body(promised: "BodySpec", true: "BodySpec", *, allow: bool = False) -> None:
    """Refuse a policy that learned with a smaller, quicker or prompter body than the true one.

    Args:
        promised: the body that the policy's contract names; a point that obeys and stops at once,
            where it says nothing.
        true: the body that it would drive.
        allow: whether that is meant so.

    Raises:
        ContractError: each thing in which the true body is worse, with both numbers.
    """
    worse = list(shortfalls(promised, true))
    if worse and not allow:
        raise ContractError(
            f"the policy learned with another body: {'; '.join(worse)}; train with --radius, "
            f"--deceleration and --delay, or {FLAG} if it is meant so"
        )


def shortfalls(promised: "BodySpec", true: "BodySpec") -> Iterator[str]:
    """Each thing in which a body is worse than the one that a policy learned with."""
    reach_m, most_m = true.footprint.reach_m, promised.footprint.reach_m
    if reach_m > most_m + _SLACK:
        yield f"it reaches {reach_m:g} m, expected at most {most_m:g} m"
    brakes, least = true.deceleration_mps2, promised.deceleration_mps2
    if brakes is not None and (least is None or brakes < least - _SLACK):
        wanted = "a stop at once" if least is None else f"at least {least:g} m/s²"
        yield f"it brakes by {brakes:g} m/s², expected {wanted}"
    delay_s, most_s = true.actuation_delay_s, promised.actuation_delay_s
    if delay_s > most_s + _SLACK:
        yield f"it obeys after {delay_s:g} s, expected at most {most_s:g} s"
