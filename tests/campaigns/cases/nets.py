"""Test nets that catch nothing."""

from cases.case import Case

CASES: tuple[Case, ...] = ()
