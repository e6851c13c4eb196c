"""Makes the recorders of `reflexarc run` and `reflexarc record`, and says what became of them."""

import json
import platform
import uuid
from dataclasses import dataclass
from pathlib import Path

from reflexarc_logs.container.run_info import UNKNOWN_BACKEND, RunInfo, installed_versions
from reflexarc_logs.recording.place import DEFAULT_RESERVE_BYTES
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.loop.clock import wall_offset_ns
from reflexarc_runtime.loop.sink import Sink
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
    guard: GuardSettings | None = None,
    senses: SenseSettings = DEFAULT,
    reserve_bytes: int = DEFAULT_RESERVE_BYTES,
) -> Recorder:
    """A recorder for `reflexarc run`: the policy attached, on the clock that the loop runs on.

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
        path, run, policy.data, config, wall_offset_ns=offset_ns, reserve_bytes=reserve_bytes
    )


def recorder_of_bus(
    path: Path, policy: bytes, robot: str, reserve_bytes: int = DEFAULT_RESERVE_BYTES
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
    return Recorder(
        path, run, policy, {}, wall_offset_ns=wall_offset_ns(), reserve_bytes=reserve_bytes
    )


@dataclass(frozen=True)
class Recording:
    """What became of a recording."""

    state: str
    parts: tuple[Path, ...] = ()
    """The files that hold it; one whose name ends in `.partial` is not finished."""
    failed: bool = False
    """Whether a disk did not take what it should have."""

    @property
    def in_words(self) -> str:
        """Where it is and what is amiss, for a person."""
        names = ", ".join(map(str, self.parts))
        if not self.state.startswith("off"):
            return f"{self.state} ({names})" if names else self.state
        return f"{names}{self.state.removeprefix('off')}" if names else self.state


def recording_of(sink: Sink) -> Recording:
    """What became of what a sink recorded; it has been closed."""
    if isinstance(sink, Recorder):
        return Recording(sink.state, sink.parts, sink.failed)
    return Recording(sink.state)
