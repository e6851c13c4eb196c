"""A body whose eye is another policy's."""

import signal
from typing import Any

from cases.case import Case, Outcome, Stage, Trial
from support.processes import finished, said_line, started
from support.ros2_robot import free_port

_FAR, _NEAR = "nearness-5-m.onnx", "colour-1500-mm.onnx"


def _run(stage: Stage, policy: str, port: int) -> dict[str, Any]:
    """The verdicts of 200 ticks beside whatever body there is."""
    words = ("run", stage.inputs / policy, "--port", port, "--ticks", 200, "--no-guard", "--json")
    with started(*words, cwd=stage.scratch) as runtime:
        return dict(finished(runtime)["verdicts"])


def _another_eye(policy: str) -> Trial:
    """A body built for one policy beside a runtime of another: never OK."""

    def tried(stage: Stage) -> Outcome:
        port = free_port()
        words = ("sim", "--policy", stage.inputs / _FAR, "--port", port, "--json")
        with started(*words, cwd=stage.scratch) as body:
            said_line(body, "robot0")
            verdicts = _run(stage, policy, port)
            way_m = finished(body, signal.SIGINT)["distance_m"]
        return Outcome("OK" not in verdicts and way_m == 0.0, f"{verdicts}, {way_m} m")

    return tried


def _one_after_the_other(stage: Stage) -> Outcome:
    port = free_port()
    with started("sim", "--port", port, "--json", cwd=stage.scratch) as body:
        said_line(body, "waiting for a runtime")
        first, second = (_run(stage, policy, port) for policy in (_FAR, _NEAR))
        finished(body, signal.SIGINT)
    rebuilt = first.get("OK", 0) > 0
    return Outcome(rebuilt, f"first {first}, then {second}")


CASES = (
    Case(
        "body-and-policy",
        "sim for one policy, run of another",
        "never OK on another's picture",
        _another_eye(_NEAR),
    ),
    Case(
        "body-and-policy",
        "sim for nobody; one policy, then the other",
        "the eye is built anew, or the second one does not drive",
        _one_after_the_other,
    ),
    Case(
        "body-and-policy",
        "sim at 180°, run at 90°",
        "never OK",
        _another_eye("nearness-5-m-90-degrees.onnx"),
    ),
)
