"""Replays that did not compare all."""

from cases.case import Case, Outcome, Said, Stage


def _few_words(said: Said) -> str:
    return f"status {said.status}: {said.everything.strip().splitlines()[0][-120:]}"


def _second_robot(stage: Stage) -> Outcome:
    said = stage.reflexarc("replay", stage.inputs / "two-robots-second-wrong.mcap")
    is_said = "robot1" in said.out and "not compared" in said.out
    return Outcome(said.status == 1 or (said.status == 0 and is_said), _few_words(said))


def _commands(stage: Stage) -> Outcome:
    said = stage.reflexarc("replay", stage.inputs / "commands-9-mps.mcap")
    differs = said.status == 1 and "first divergence: tick 0, sent.linear_mps" in said.out
    return Outcome(differs, _few_words(said))


def _second_half(stage: Stage) -> Outcome:
    said = stage.reflexarc("replay", stage.inputs / "second-half.mcap")
    policy = "50 compared, 50 identical" in said.out
    begins = "level node begins behind" in said.out or "level node was left out" in said.out
    return Outcome(said.status == 0 and policy and begins, _few_words(said))


def _late_times(stage: Stage) -> Outcome:
    said = stage.reflexarc("replay", stage.inputs / "all-times.mcap")
    one_line = said.status == 2 and len(said.complaint.splitlines()) == 1
    compared = said.status == 0 and "98 compared, 98 identical" in said.out
    return Outcome((one_line or compared) and not said.has_traceback, _few_words(said))


CASES: tuple[Case, ...] = (
    Case(
        "replay-not-compared",
        "logs of two robots merged into one, the second one's Q-values wrong by 1",
        "status 1, or a note that its ticks were not compared",
        _second_robot,
    ),
    Case(
        "replay-not-compared",
        "ticks of 1 m/s, recorded commands of 9 m/s",
        "status 1 with the tick",
        _commands,
    ),
    Case(
        "mcap-cut-by-time",
        "the second half of a log, cut by time",
        "50 of 50 at level policy; level node begins behind the cut, or says why not",
        _second_half,
    ),
    Case(
        "times-beyond-int64",
        "all times near 2^64, replayed",
        "one line and status 2, or a comparison; no traceback",
        _late_times,
    ),
)
