"""Pictures as people have them."""

from cases.case import Case

CASES: tuple[Case, ...] = ()
