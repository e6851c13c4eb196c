"""A judgement that is made up: as many logs and flips as a test asks for."""

import numpy as np

from reflexarc_logs.judging.judgement import IncidentAnswer, JudgedFlip, LogJudgement
from reflexarc_logs.judging.judgement_report import Judgement

SHAPE = (2, 1, 16, 1)
EVIL = "<script>throw 1</script>[red]a\x1b[31m/\u202e&amp;'\".mcap"


def made_flip(k: int, shape: tuple[int, ...] = SHAPE, actions: int = 3) -> JudgedFlip:
    generator = np.random.default_rng(k)
    recorded, candidate = generator.normal(size=(2, actions)) * 3.0
    was, now = int(recorded.argmax()), int(candidate.argmax())
    return JudgedFlip(
        tick=50 * k + 7,
        time_s=k + 0.14,
        recorded=was,
        candidate=now,
        margin=float(recorded[was] - recorded[now]),
        candidate_margin=float(candidate[now] - candidate[was]),
        is_reversal=k % 5 == 0,
        recorded_q_values=tuple(recorded.tolist()),
        candidate_q_values=tuple(candidate.tolist()),
        retina=generator.integers(0, 256, shape, np.uint8).tobytes(),
    )


def made_log(
    name: str = "drive.mcap",
    flips: int = 3,
    more: int = 0,
    shape: tuple[int, ...] = SHAPE,
    actions: tuple[str, ...] = ("stay", "left", "right"),
) -> LogJudgement:
    shown = tuple(made_flip(k, shape, len(actions)) for k in range(flips))
    return LogJudgement(
        log=name,
        broken=(f"{flips + more} flips of at most 0",) if flips else (),
        recorded_policy="ab" * 32,
        actions=actions,
        retina_shape=shape,
        ticks=3000,
        flips=flips + more,
        reversals=sum(flip.is_reversal for flip in shown),
        largest_margin=max((flip.margin for flip in shown), default=0.0),
        first_tick=shown[0].tick if shown else -1,
        first_s=shown[0].time_s if shown else 0.0,
        shown_flips=shown,
        more_flips=more,
        incidents=(
            IncidentAnswer("contact", 33, 0.66, "number 1, at 0.62, 11.67 m", 33, 0, 1),
            IncidentAnswer("stop", 90, 1.8, name, -1, -1, -1),
        ),
    )


def made_judgement(*logs: LogJudgement, candidate: str = "new.onnx") -> Judgement:
    return Judgement(candidate, "cd" * 32, ("at most 0 flips",), logs)
