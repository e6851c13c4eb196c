"""Replays that did not compare all."""

from cases.case import Case

CASES: tuple[Case, ...] = ()
