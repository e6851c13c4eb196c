"""Logs that were cut, damaged, compressed or written again by other tools."""

from cases.case import Case

CASES: tuple[Case, ...] = ()
