"""Whether a new policy is as good as an old one: non-inferiority, family by family.

Both drive through the same worlds from the same places. In each family the loss is

    loss = Σ contacts of the new / Σ contacts of the old − 1

over distances of the same length (for bodies that turn: Σ reach of the old / Σ reach of the new
− 1). Its error is that of a ratio of sums over worlds (Cochran, *Sampling Techniques*, 1977,
section 6.4), on the logarithm, so that a loss and its reverse are treated alike.

Two claims are tested in each family, at some looks after more and more driving:

- *loses*: the loss is more than the margin. A false alarm in any family must be rare: Holm's
  correction over the families (Holm 1979).
- *keeps*: the loss is less than the margin. A policy keeps if it keeps in every family; each at
  the full level, for all must hold (intersection–union test, Berger 1982).

What is shown by neither is undecided. Each look has its part of the level (`SPENT`), and the
p-value over all looks is the smallest of the p-values, each weighted by its part (Bonferroni).
The last look is the one at which the error is small enough, so that a family is driven as far as
its dispersion needs; it has all of the level that is left. The error says nothing of the loss, so
ending by it raises no alarms (Mehta, Tsiatis, *Flexible sample size considerations using
information-based interim monitoring*, 2001).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from statistics import NormalDist

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.track import Floats

SPENT = (0.02, 0.03, 0.05, 0.1, 0.8)
"""Share of the level that each look may use. What is plain is so at any level, and what is not has
all of the driving behind it at the last look: there a share that is small would cost the most."""
POWER = 0.8
"""Probability with which the smallest loss that is named would have been found."""
PLAIN = 1.5
"""A loss of so many margins should be found …"""
PLAIN_POWER = 0.9
"""… with this probability: an error with which it is needs no further look."""

_NORMAL = NormalDist()


class Claim(StrEnum):
    """What was shown of a family, or of all."""

    KEEPS = "keeps"
    LOSES = "loses"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Look:
    """What one look at a family found."""

    log_ratio: float
    """Logarithm of 1 + loss."""
    error: float
    """Standard error of it."""

    def p_loses(self, margin: float) -> float:
        """Of "the loss is at most the margin": small where it is more."""
        return _above(self.log_ratio - math.log1p(margin), self.error)

    def p_keeps(self, margin: float) -> float:
        """Of "the loss is at least the margin": small where it is less."""
        return _above(math.log1p(margin) - self.log_ratio, self.error)


@dataclass(frozen=True)
class FamilyVerdict:
    """What was found in a family."""

    family: str
    claim: Claim
    loss: float
    """New contacts per old contact, less 1."""
    low: float
    """95 % interval of the loss, of this family alone."""
    high: float
    smallest: float
    """Smallest loss that would have been found with a probability of 80 %."""
    looks: int


def look_at(new: Floats, old: Floats) -> Look:
    """The loss and its error, from sums over worlds.

    Args:
        new: contacts of the new policy in each world: (worlds,), 2 or more.
        old: those of the old one.
    """
    if not new.sum() and not old.sum():
        return Look(0.0, 0.0)
    # Half a contact on either side keeps the logarithm finite where one of them has none.
    total_new, total_old = float(new.sum()) + 0.5, float(old.sum()) + 0.5
    spread = new / total_new - old / total_old
    n = len(new)
    variance = n / (n - 1) * float((spread**2).sum())
    floor = 0.0 if np.array_equal(new, old) else 1.0 / total_new + 1.0 / total_old
    # Paired worlds may differ in so few contacts that their spread says nothing yet.
    few = min(total_new, total_old) < _FEW_CONTACTS
    error = math.sqrt(max(variance, floor) if few else variance)
    return Look(math.log(total_new / total_old), error)


_FEW_CONTACTS = 50
"""Below it an error is at least that of two independent Poisson counts."""


def is_last(looks: Sequence[Look], margin: float, alpha: float, families: int) -> bool:
    """Whether no look need follow: the error is small enough, or there are no more looks."""
    if len(looks) == len(SPENT):
        return True
    plain = math.log1p(PLAIN * margin) - math.log1p(margin)
    level = alpha * shares(len(looks), is_last=True)[-1] / families
    return looks[-1].error <= plain / _errors_away(level, PLAIN_POWER)


def shares(looks: int, *, is_last: bool) -> tuple[float, ...]:
    """Share of the level of each look so far; the last one has all that is left."""
    before = SPENT[: looks - 1]
    return (*before, 1.0 - sum(before) if is_last else SPENT[looks - 1])


def p_over_looks(p_values: Sequence[float], *, is_last: bool) -> float:
    """The p-value of all looks together: no smaller than 1 level in a share of that level."""
    parts = shares(len(p_values), is_last=is_last)
    return min(1.0, min(p / share for p, share in zip(p_values, parts, strict=True)))


def holm(p_values: Mapping[str, float]) -> dict[str, float]:
    """Adjusted p-values: those at most α are rejected with a family-wise error of at most α."""
    adjusted, largest = dict[str, float](), 0.0
    for rank, name in enumerate(sorted(p_values, key=p_values.__getitem__)):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[name]))
        adjusted[name] = largest
    return adjusted


def is_decided(looks: Sequence[Look], margin: float, alpha: float, families: int) -> bool:
    """Whether more driving could not, or need not, change what is said of a family."""
    ends = is_last(looks, margin, alpha, families)
    keeps = p_over_looks([look.p_keeps(margin) for look in looks], is_last=ends)
    loses = p_over_looks([look.p_loses(margin) for look in looks], is_last=ends)
    return ends or keeps <= alpha or loses <= alpha / families


def judge(
    looks: Mapping[str, Sequence[Look]], margin: float, alpha: float
) -> tuple[FamilyVerdict, ...]:
    """The verdict on each family.

    Args:
        looks: at each family, one or more.
        margin: largest loss that is still borne, as a share: 0.1 for a tenth more contacts.
        alpha: family-wise level, 0.05 for 5 %.
    """
    ends = {name: is_last(found, margin, alpha, len(looks)) for name, found in looks.items()}
    loses = holm(
        {
            name: p_over_looks([look.p_loses(margin) for look in found], is_last=ends[name])
            for name, found in looks.items()
        }
    )
    return tuple(
        _verdict(name, found, loses[name], margin, alpha, len(looks))
        for name, found in looks.items()
    )


def overall(verdicts: Sequence[FamilyVerdict]) -> Claim:
    """Of all families: loses if any loses, keeps if all keep."""
    claims = {verdict.claim for verdict in verdicts}
    if Claim.LOSES in claims:
        return Claim.LOSES
    return Claim.KEEPS if claims == {Claim.KEEPS} else Claim.UNDECIDED


def _verdict(
    name: str, looks: Sequence[Look], loses: float, margin: float, alpha: float, families: int
) -> FamilyVerdict:
    last, ends = looks[-1], is_last(looks, margin, alpha, families)
    keeps = p_over_looks([look.p_keeps(margin) for look in looks], is_last=ends)
    claim = Claim.LOSES if loses <= alpha else Claim.KEEPS if keeps <= alpha else Claim.UNDECIDED
    half = _NORMAL.inv_cdf(0.975) * last.error
    level = alpha * shares(len(looks), is_last=ends)[-1] / families
    return FamilyVerdict(
        family=name,
        claim=claim,
        loss=math.expm1(last.log_ratio),
        low=math.expm1(last.log_ratio - half),
        high=math.expm1(last.log_ratio + half),
        smallest=math.expm1(math.log1p(margin) + _errors_away(level, POWER) * last.error),
        looks=len(looks),
    )


def _errors_away(level: float, power: float) -> float:
    """So many errors above the margin a loss is found at that level, with that probability."""
    return _NORMAL.inv_cdf(1.0 - level) + _NORMAL.inv_cdf(power)


def _above(value: float, error: float) -> float:
    """P(a normal deviate of that error exceeds the value); certain where there is no error."""
    if error == 0.0:
        return 0.0 if value > 0.0 else 1.0
    return 1.0 - _NORMAL.cdf(value / error)
