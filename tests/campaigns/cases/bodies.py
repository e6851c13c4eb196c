"""A body whose eye is another policy's."""

from cases.case import Case

CASES: tuple[Case, ...] = ()
