"""What only a log of ours can be asked: its losses, its policy, and whether it replays."""

from collections.abc import Iterator, Mapping

from reflexarc_logs.checking.findings import LogFinding, error, warning
from reflexarc_logs.container.run_info import LOOPS
from reflexarc_logs.container.writing import END
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.recording.part import PART
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import LogError, ReflexarcError
from reflexarc_runtime.loop.trials.tried_policy import load_tried_policy
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.words.suggestion import pasteable

CUT = "reflexarc.cut"
"""Metadata of a part that was cut out of a log."""
_MISSING = {
    "dropped": "records were dropped by the recorder: the disk was too slow, or full",
    "damaged_chunks": "chunks were damaged, and left out by `recover`",
}


def loss_findings(metadata: Mapping[str, Mapping[str, str]]) -> Iterator[LogFinding]:
    """What the log itself says is missing.

    Args:
        metadata: all that it says about itself.
    """
    said = metadata.get(END, {})
    for name, words in _MISSING.items():
        if said.get(name, "0") != "0":
            yield error("completeness", f"{said[name][:20]} {words}")
    if said.get("left_out", "0") != "0":
        yield warning("completeness", f"{said['left_out'][:20]} messages of others were left out")
    part = metadata.get(PART, {})
    if part.get("lost", "0") != "0":
        yield error("completeness", f"{part['lost'][:20]} records were lost before this part began")


def should_hold_all(log: Log) -> bool:
    """Whether it should hold a run of a loop from its first tick to its last."""
    following = log.path.with_name(f"{log.path.stem}.part2{log.path.suffix}")
    is_part = CUT in log.metadata or PART in log.metadata or following.exists()
    return log.run.recorded_by in LOOPS and not is_part


def contract_findings(log: Log) -> Iterator[LogFinding]:
    """Whether the policy that decided is in the log, is the one that it names, and is sealed."""
    named = log.run.policy_hash
    try:
        policy = log.policy
    except LogError as refusal:
        yield error("contract", str(refusal).removeprefix(f"{log.path}: "))
        return
    if policy is None:
        if named:
            words = f"it names the policy {named[:12]}, but none is attached"
            yield error("contract", words)
        elif log.run.recorded_by != "import":
            yield warning("contract", "no policy is attached: it cannot be replayed by itself")
        return
    found = policy_hash(policy)
    if found != named:
        words = f"the attached policy is {found[:12]}, but the log names {named[:12] or 'none'}"
        yield error("contract", words)
    try:
        loaded = load_tried_policy(policy, log.run.replay_backend)
    except ReflexarcError as refusal:
        yield error("contract", f"the attached policy is not intact: {refusal}")
        return
    if not loaded.digest:
        yield warning("contract", "no digest seals the policy's contract: it is of an old schema")


def replay_findings(log: Log) -> tuple[str, list[LogFinding]]:
    """The verdict of its replay, and what is amiss with it."""
    try:
        report = replay(read_log(log.path))
    except ReflexarcError as refusal:
        words = str(refusal).removeprefix(f"{log.path}: ")
        return "not possible", [warning("replay", f"it cannot be replayed: {words}")]
    if not report.exit_status:
        return report.verdict, []
    if report.exit_status == 1:
        more = f"see `{pasteable('reflexarc', 'replay', log.path)}`"
        words = repr(report).partition(f"{log.path}: ")[2].rstrip(">")
        return report.verdict, [error("replay", f"replay: {words}; {more}")]
    notes = "; ".join(report.notes[:2])
    return report.verdict, [warning("replay", f"replay: nothing was compared: {notes}")]
