"""Scans as drivers send them, and as scanners are mounted."""

from dataclasses import replace

import numpy as np

from cases.case import Case, Outcome, Stage, Trial
from reflexarc_logs.container.rejected import accepted_message
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.messages.wire import Stamp, UndecodableError, UnfitError
from reflexarc_runtime.ros2.cdr import UnusableMessageError
from reflexarc_runtime.ros2.laser_scan import STANDARD, RosScanner, decode_scan, encode_scan
from reflexarc_runtime.sensing.range_meaning import RangeMeaning
from reflexarc_runtime.sensing.senses import ScanSense

_LEFT = [0, 0, 0, 204, 204, *[0] * 11]
_TOO_NEAR = [0, 0, 0, 255, 255, *[0] * 11]
_BEHIND = [*[0] * 5, *[153] * 6, *[0] * 5]
"""The wall at 2 m, in front of a scanner that looks backwards."""


def retina_of(payload: bytes) -> list[int] | str:
    """What the runtime makes of a `foxglove.LaserScan`: a retina, or why there is none."""
    message = accepted_message(
        "robot0/scan", "foxglove.LaserScan", payload, Stamp(1, 1_000_000_000), 1_000_000_000
    )
    try:
        sensed = ScanSense(RetinaSpec()).decode(message)
    except (UndecodableError, UnfitError) as error:
        return str(error)
    return [int(value) for value in np.ravel(sensed.retina)]


def retina_from_ros(payload: bytes, scanner: RosScanner = STANDARD) -> list[int] | str:
    """What becomes of a `sensor_msgs/LaserScan` by `reflexarc ros2` and `reflexarc run`."""
    try:
        return retina_of(encode_scan(decode_scan(payload, scanner)))
    except UnusableMessageError as error:
        return str(error)


def _ros(name: str, *right: list[int], refusal: str = "", no_return: tuple[str, ...] = ()) -> Trial:
    """A payload gives one of these retinas, or a refusal with these words."""

    def tried(stage: Stage) -> Outcome:
        scanner = replace(STANDARD, meaning=RangeMeaning(no_return=no_return))
        got = retina_from_ros((stage.inputs / name).read_bytes(), scanner)
        holds = refusal != "" and refusal in got if isinstance(got, str) else got in right
        return Outcome(holds, str(got))

    return tried


def _with_and_without(name: str, word: str) -> Trial:
    """Refused without the flag, and the reason names it; the right retina with it."""

    def tried(stage: Stage) -> Outcome:
        without = _ros(name, refusal=f"--no-return {word}")(stage)
        with_flag = _ros(name, _LEFT, no_return=(word,))(stage)
        holds = without.holds and with_flag.holds
        return Outcome(holds, f"without: {without.seen}; with: {with_flag.seen}")

    return tried


def _mounted(name: str, *right: list[int], refusal: str = "") -> Trial:
    def tried(stage: Stage) -> Outcome:
        got = retina_of((stage.inputs / name).read_bytes())
        holds = refusal != "" and refusal in got if isinstance(got, str) else got in right
        return Outcome(holds, str(got))

    return tried


CASES = (
    Case(
        "laserscan-ros2",
        "range-max-zero.cdr",
        "refused with a reason, or without limit",
        _ros("range-max-zero.cdr", _LEFT, refusal="range_max"),
    ),
    Case(
        "laserscan-ros2",
        "below-range-min.cdr",
        "rays 3 and 4 are 255, or not OK",
        _ros("below-range-min.cdr", _TOO_NEAR, refusal="unknown"),
    ),
    Case("laserscan-ros2", "degrees.cdr", "refused", _ros("degrees.cdr", refusal="turns")),
    Case(
        "laserscan-ros2",
        "no-return-zero.cdr",
        "refused without a flag that the reason names; right with it",
        _with_and_without("no-return-zero.cdr", "zero"),
    ),
    Case(
        "laserscan-ros2",
        "range-max-4-means-nothing.cdr",
        "rays 3 and 4 are 204",
        _ros("range-max-4-means-nothing.cdr", _LEFT),
    ),
    Case(
        "laserscan-ros2",
        "range-max-negative.cdr",
        "as range-max-zero",
        _ros("range-max-negative.cdr", _LEFT, refusal="range_max"),
    ),
    Case(
        "laserscan-ros2",
        "all-below-range-min-but-few.cdr",
        "rays 3 and 4 are 255, or not OK",
        _ros("all-below-range-min-but-few.cdr", _TOO_NEAR, refusal="unknown"),
    ),
    Case(
        "laserscan-ros2",
        "no-return-nan.cdr",
        "as no-return-zero",
        _with_and_without("no-return-nan.cdr", "nan"),
    ),
    Case("laserscan-pose", "straight.pb", "rays 3 and 4 are 204", _mounted("straight.pb", _LEFT)),
    Case(
        "laserscan-pose",
        "turned-180.pb",
        "the wall behind, in front",
        _mounted("turned-180.pb", _BEHIND),
    ),
    Case("laserscan-pose", "degrees.pb", "refused", _mounted("degrees.pb", refusal="turns")),
)
