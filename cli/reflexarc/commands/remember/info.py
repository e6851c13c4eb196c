"""`reflexarc info`: describes a policy or a log."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import tyro
from rich.table import Table

from reflexarc.terminal.output import console, facts, kibibytes, print_json
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_logs.reading.summary import TopicSummary

MCAP_MAGIC = b"\x89MCAP"
SHOWN_HASH = 12


@dataclass(frozen=True)
class InfoCommand:
    """Describe a file: the contract and origin of a policy, or the run and streams of a log.

    Examples:
      reflexarc info runs/reflex-0/policy.onnx
      reflexarc info runs/drive.mcap --json
    """

    file: tyro.conf.Positional[Path]
    """A policy (ONNX) or a log (MCAP)."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Print what the file is."""
        if _begins_with(self.file, MCAP_MAGIC) or self.file.suffix in (".mcap", ".partial"):
            return self._of_log()
        return self._of_policy()

    def _of_policy(self) -> int:
        from reflexarc_runtime.policy.policy import load_policy

        policy = load_policy(self.file, verify=False)
        contract, origin = policy.contract, policy.contract.provenance
        if self.json:
            print_json({"policy_hash": policy.policy_hash, "contract": asdict(contract)})
            return 0
        eye = contract.retina
        rows: dict[str, object] = {
            "policy": self.file,
            "hash": policy.policy_hash,
            "sees": f"{eye.eyes} eye, {eye.rays} rays over {eye.fov_rad:.3f} rad, "
            f"{eye.range_m:g} m, {eye.shading}, {eye.channels} channel, {eye.frames} frame",
            "does": ", ".join(action.name for action in contract.actions),
            "rate": f"{contract.rate_hz:g} Hz, inputs at most {contract.max_input_age_s:g} s old",
            "learned as": f"preset {origin.preset}, seed {origin.seed}, "
            f"configuration {origin.config_hash[:SHOWN_HASH]}",
            "commit": origin.commit or "unknown",
            "scores": ", ".join(f"{k} {v:g}" for k, v in origin.scores.items()) or "none",
            "golden vectors": len(contract.golden.retinas),
        }
        console.print(facts(rows))
        return 0

    def _of_log(self) -> int:
        from reflexarc_logs.reading.summary import summarise

        summary = summarise(self.file)
        if self.json:
            print_json(summary)
            return 0
        run = summary.run
        state = "complete" if summary.complete else "cut off: see `reflexarc recover`"
        console.print(
            facts(
                {
                    "log": f"{self.file} ({state})",
                    "run": f"{run.run_id}, {run.recorded_by} on {run.host}, {run.clock} clock",
                    "policy": summary.policy_hash or "none attached",
                    "size": f"{kibibytes(summary.bytes)}, {summary.messages} messages, "
                    f"{summary.duration_s:.1f} s",
                }
            )
        )
        console.print(_topics(summary.topics))
        return 0


def _begins_with(path: Path, magic: bytes) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(magic)) == magic
    except OSError as error:
        raise UsageError(
            f"{path}: cannot be read: {error.strerror}; give a policy (.onnx) or a log (.mcap)"
        ) from None


def _topics(topics: "tuple[TopicSummary, ...]") -> Table:
    table = Table()
    for name in ("topic", "message", "messages", "rate", "payload"):
        table.add_column(name, justify="left" if name in ("topic", "message") else "right")
    for topic in topics:
        rate = f"{topic.rate_hz:.1f} Hz" if topic.rate_hz else ""
        size = kibibytes(topic.payload_bytes)
        table.add_row(topic.topic, topic.schema, str(topic.messages), rate, size)
    return table
