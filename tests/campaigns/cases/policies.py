"""Policies as exporters write them."""

from cases.case import Case

CASES: tuple[Case, ...] = ()
