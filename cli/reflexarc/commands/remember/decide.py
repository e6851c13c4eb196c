"""`reflexarc decide`: a policy on a log of sensors alone."""

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from reflexarc.terminal.output import console, facts, print_json
from reflexarc.wiring.guard_flags import GuardFlags
from reflexarc.wiring.sense_flags import SenseFlags

if TYPE_CHECKING:
    from reflexarc_logs.deciding.decide import Decided


@dataclass(frozen=True)
class DecideCommand:
    """Decide on the sensors of a log with any policy, offline, as the loop would have at its rate.

    The log may be ours, or imported; what it decided itself is left out. The result is a log as
    `run --record` writes it: it replays, it can be cut, drawn and compared. It is open loop: the
    robot saw what it saw, whatever is decided now. It is replayed at once; exit status 1 if that
    differs, or if nothing in the log was good enough for the policy to be asked once.

    Examples:
      reflexarc import carmen intel.log.gz -o runs/intel.mcap
      reflexarc decide runs/intel.mcap --policy runs/reflex-0/policy.onnx -o runs/intel-reflex.mcap
      reflexarc decide runs/drive.mcap --policy new.onnx -o runs/new.mcap --no-guard
    """

    log: tyro.conf.Positional[Path]
    """A log (MCAP) that holds retinas or scans."""
    policy: Path
    """The policy that decides (ONNX)."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The log to be; it must not exist."""
    input: Literal["", "retina", "scan"] = ""
    """Which sensor stream to decide on; by default, the only one of the log."""
    backend: Literal["numpy", "onnxruntime"] = "numpy"
    """What computes the policy."""
    sensing: SenseFlags = field(default_factory=SenseFlags)
    guarding: GuardFlags = field(default_factory=GuardFlags)
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Decide, and replay what was decided; the status is the replay's, or 1 if nothing was."""
        from reflexarc_logs.deciding.decide import decide
        from reflexarc_logs.reading.reader import read_log
        from reflexarc_logs.replaying.replay import replay
        from reflexarc_runtime.loop.trials.tried_policy import load_tried_policy

        policy = load_tried_policy(self.policy, self.backend)
        decided = decide(
            read_log(self.log),
            policy,
            self.out,
            sensor=self.input,
            senses=self.sensing.settings,
            guard=self.guarding.settings_for(policy.contract),
        )
        report = replay(decided.path)
        self._tell(decided, report.verdict)
        return report.exit_status or int(bool(decided.why_nothing))

    def _tell(self, decided: "Decided", verdict: str) -> None:
        if self.json:
            print_json({**asdict(decided), "replay": verdict})
            return
        left_out = ", ".join(f"{topic} {n}" for topic, n in decided.left_out.items())
        rows: dict[str, object] = {
            "log": decided.path,
            "decided on": f"{decided.sensor}s, {decided.ticks} ticks",
            "verdicts": ", ".join(f"{name} {n}" for name, n in decided.verdicts.items()),
            "replay": verdict,
        }
        if decided.why_nothing:
            rows["not asked"] = f"the policy, at any tick: {decided.why_nothing}"
        if left_out:
            rows["left out"] = left_out
        console.print(facts(rows))
