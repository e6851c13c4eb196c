"""Makes the recorders of `reflexarc run` and `reflexarc record`."""

import json
import platform
import uuid
from collections.abc import Mapping
from pathlib import Path

from reflexarc_logs.container.run_info import UNKNOWN_BACKEND, RunInfo, installed_versions
from reflexarc_logs.recording.black_box import BoxSpan
from reflexarc_logs.recording.keeping import DEFAULT_KEEPING, Keeping
from reflexarc_logs.recording.recorder import NO_OTHERS, Recorder
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.loop.clock import wall_offset_ns
from reflexarc_runtime.policy.policy import LoadedPolicy
from reflexarc_runtime.sensing.sense_settings import SenseSettings
from reflexarc_runtime.sensing.senses import DEFAULT


def recorder_of_run(
    path: Path,
    policy: LoadedPolicy,
    *,
    run_id: str,
    robot: str,
    sensor: str,
    lockstep: bool,
    pace: str = "",
    guard: GuardSettings | None = None,
    senses: SenseSettings = DEFAULT,
    keeping: Keeping = DEFAULT_KEEPING,
    box: BoxSpan | None = None,
    others: Mapping[str, bytes] = NO_OTHERS,
) -> Recorder:
    """A recorder for `reflexarc run`: the policy attached, on the clock that the loop runs on.

    With `box` it is a black box; `others` are policies that it holds beside the first one.

    Raises:
        LogError: the path exists, or cannot be written.
    """
    contract = policy.contract
    run = RunInfo(
        run_id=run_id,
        robot=robot,
        input=sensor,
        backend=policy.backend.value,
        rate_hz=contract.rate_hz,
        clock="lockstep" if lockstep else "monotonic",
        pace=pace,
        guard="" if guard is None else guard.to_json(),
        senses=senses.to_json(),
        policy_seed=contract.provenance.seed,
        commit=contract.provenance.commit,
        host=platform.node(),
        versions=installed_versions(),
    )
    config = {"contract": json.loads(contract.to_json())}
    offset_ns = 0 if lockstep else wall_offset_ns()
    return Recorder(
        path,
        run,
        policy.data,
        config,
        wall_offset_ns=offset_ns,
        keeping=keeping,
        box=box,
        others=others,
    )


def recorder_of_bus(
    path: Path, policy: bytes, robot: str, keeping: Keeping = DEFAULT_KEEPING
) -> Recorder:
    """A recorder for `reflexarc record`: all messages, in the order in which they arrive.

    Raises:
        LogError: the path exists, or cannot be written.
    """
    run = RunInfo(
        run_id=uuid.uuid4().hex,
        robot=robot,
        recorded_by="record",
        backend=UNKNOWN_BACKEND,
        host=platform.node(),
        versions=installed_versions(),
    )
    return Recorder(path, run, policy, {}, wall_offset_ns=wall_offset_ns(), keeping=keeping)
