"""Bags of ROS 2, and names that look like markup."""

from cases.case import Case

CASES: tuple[Case, ...] = ()
