"""Scans in any convention, of any mounting, against a slow picture of all beams."""

from hypothesis import HealthCheck, given, seed, settings

from support.drawn_scans import Drawn, scans
from support.scan_judge import judge


@seed(20)
@settings(max_examples=500, deadline=None, database=None, suppress_health_check=list(HealthCheck))
@given(scans())
def test_no_sector_is_darker_than_its_nearest_return_and_nothing_unknown_is_free(drawn: Drawn):
    judge(drawn)
