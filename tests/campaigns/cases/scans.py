"""Scans as drivers send them."""

from cases.case import Case

CASES: tuple[Case, ...] = ()
