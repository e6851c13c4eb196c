"""A study of sixteen runs, and results for it that no run gave."""

from reflexarc_trainer.study.definition import Study, parse_study
from reflexarc_trainer.study.unit import Result, code_key

STUDY_TEXT = """\
title = "Nothing in particular"
question = "What if?"
preset = "online"
seeds = 4

[[axis]]
label = "hidden units"
field = "network.hidden"
values = [5, 20]

[[axis]]
label = "eye"

[[axis.choice]]
name = "long"

[[axis.choice]]
name = "short"
"retina.range_m" = 1.0
"""


def small_study() -> Study:
    return parse_study(STUDY_TEXT, "mine")


def results_of(study: Study) -> dict[str, Result]:
    """Figures 0 to 15 by seed and cell; the last one has diverged, the first of all is missing."""
    found = {}
    for n, unit in enumerate(study.units()):
        figure = None if n == 15 else float(n)
        share = None if figure is None else figure / 10.0
        found[unit.hash] = Result(unit.hash, code_key(), figure is None, 9, 1.0, 1.0, figure, share)
    del found[study.units()[0].hash]
    return found
