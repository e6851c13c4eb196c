"""Machines as they are."""

from cases.case import Case

CASES: tuple[Case, ...] = ()
