"""Lidar logs of other systems."""

from cases.case import Case

CASES: tuple[Case, ...] = ()
