"""`reflexarc info`: describes a policy or a log."""

from dataclasses import asdict, dataclass
from pathlib import Path

import tyro

from reflexarc.terminal.output import console, print_json
from reflexarc.wiring.policy_trials import BackendName
from reflexarc_runtime.errors import UsageError

MCAP_MAGIC = b"\x89MCAP"


@dataclass(frozen=True)
class InfoCommand:
    """Describe a file: the contract and origin of a policy, or the run and streams of a log.

    Of a policy: all its speeds, what it waits for, the body that it learned with, and what a robot
    would refuse without a flag. Of a log: also the guard's settings, the watchdog, and, where a
    body drove, the world, its seed and the body's limits; with --json the text of the world's file.
    A log of over 4 MiB is counted by its index, the CRC of its data checked. Of a log of another
    system (a bag of ROS 2 in MCAP): its topics, types, counts and times.

    Examples:
      reflexarc info runs/reflex-0/policy.onnx
      reflexarc info runs/drive.mcap --json
    """

    file: tyro.conf.Positional[Path]
    """A policy (ONNX) or a log (MCAP)."""
    backend: BackendName = "numpy"
    """What has to be able to compute the policy."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Print what the file is."""
        if _begins_with(self.file, MCAP_MAGIC) or self.file.suffix in (".mcap", ".partial"):
            return self._of_log()
        return self._of_policy()

    def _of_policy(self) -> int:
        from reflexarc.terminal.policy_description import describe_policy
        from reflexarc_runtime.contract.bounds import excesses
        from reflexarc_runtime.loop.trials.tried_policy import load_tried_policy
        from reflexarc_runtime.policy.policy import USUAL_BOUNDS

        policy = load_tried_policy(self.file, self.backend, verify=False)
        if not self.json:
            console.print(describe_policy(self.file, policy))
            return 0
        print_json(
            {
                "policy_hash": policy.policy_hash,
                "digest": policy.digest,
                "notes": policy.notes,
                "beyond_usual_bounds": list(excesses(policy.contract, USUAL_BOUNDS)),
                "contract": asdict(policy.contract),
            }
        )
        return 0

    def _of_log(self) -> int:
        from reflexarc.terminal.log_description import describe_foreign, describe_log
        from reflexarc_logs.reading.summary import ForeignSummary, describe_any

        summary = describe_any(self.file)
        if self.json:
            print_json(summary)
        elif isinstance(summary, ForeignSummary):
            console.print(describe_foreign(self.file, summary))
        else:
            console.print(describe_log(self.file, summary))
        return 0


def _begins_with(path: Path, magic: bytes) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(magic)) == magic
    except OSError as error:
        from reflexarc_logs.container.first_look import check_is_no_folder

        check_is_no_folder(path)
        raise UsageError(
            f"{path}: cannot be read: {error.strerror}; give a policy (.onnx) or a log (.mcap)"
        ) from None
