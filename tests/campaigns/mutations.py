"""Is replay, or diff, an empty check? Seeded changes of what they compare, to be found and named.

    python tests/campaigns/mutations.py [--count 10000] [--seed 0]

Each change alters one thing in a recorded drive, as a forger with valid CRCs would: a field of one
decision, a field of one command, one ray of an input that was used, or one weight of the attached
policy (by half of itself, and by one). Replay has to say "different", and name the tick; diff
against the log as it was has to name the very message and field. A weight that no retina of the
log reaches, by what the policy itself says, is drawn anew, and an input at which the policy was not
asked decides nothing. The status is 1 if a change was missed or misplaced.
"""

import argparse
import random
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

import numpy as np
import onnx
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf.message import Message as ProtobufMessage
from onnx import numpy_helper

from reflexarc_logs.container.run_info import RUN
from reflexarc_logs.container.writing import POLICY_ATTACHMENT
from reflexarc_logs.diffing.diff import diff
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_runtime.messages_pb2 import Command, Decision, Tick
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from support.policies import exported
from support.recordings import CONTRACT, drive, nominal
from support.rewriting import rewrite

TICKS = 60
KINDS = ("decision", "command", "input", "weight")
TAKEN_AS_GIVEN = {"slot", "now_ns"}
"""Of a decision: nothing in a log tells them twice; replay says so."""
NOT_IN_TICKS = {"sequence", "body"}


@dataclass(frozen=True)
class Change:
    """What was changed."""

    kind: str
    tick: int
    """The first tick that it reaches, by its number in the log."""
    topic: str
    message: int
    """Its number on its topic; −1: it is no message."""
    field: str


class Forger:
    """Makes seeded changes of one log."""

    def __init__(self, folder: Path, log: Log, seed: int) -> None:
        self._folder, self._log, self._draw = folder, log, random.Random(seed)
        self._ticks = [tick.decision for tick in log.ticks()]
        self._policy = load_policy(log.policy or b"")

    def forged(self, number: int) -> tuple[Path, Change]:
        """A log with one change."""
        out = self._folder / f"{number}.mcap"
        kind = KINDS[number % len(KINDS)]
        return out, getattr(self, f"_{kind}")(out)

    def _decision(self, out: Path) -> Change:
        nth = self._draw.randrange(len(self._ticks))
        tick = Tick(decision=self._ticks[nth])
        field = _alter(tick.decision, self._draw, TAKEN_AS_GIVEN | {"command", "input"})
        called = tick.decision.index  # replay calls a tick by the number that the log gives it
        self._rewrite(out, "/robot0/tick", nth, lambda data: _with(Tick, data, tick.decision))
        return Change("decision", called, "/robot0/tick", nth, f"decision.{field}")

    def _command(self, out: Path) -> Change:
        nth = self._draw.randrange(len(self._ticks))
        sent = Command()
        sent.CopyFrom(self._ticks[nth].command)
        field = _alter(sent, self._draw, NOT_IN_TICKS)
        self._rewrite(out, "/robot0/command", nth, lambda data: sent.SerializeToString())
        return Change("command", nth, "/robot0/command", nth, field)

    def _input(self, out: Path) -> Change:
        used = [n for n, d in enumerate(self._ticks) if d.q_values]
        tick = self._draw.choice(used)
        wanted = self._ticks[tick].input.sequence
        records = list(self._log.records("/robot0/retina"))
        nth = next(n for n, r in enumerate(records) if r.sequence == wanted)
        image = RawImage.FromString(records[nth].payload)
        ray, by = self._draw.randrange(len(image.data)), self._draw.randrange(1, 256)
        image.data = _changed(image.data, ray, by)
        self._rewrite(out, "/robot0/retina", nth, lambda data: image.SerializeToString())
        return Change("input", tick, "/robot0/retina", nth, "data")

    def _weight(self, out: Path) -> Change:
        """A weight that some retina of the log reaches, by what the policy itself says."""
        while True:
            data = _with_another_weight(self._log.policy or b"", self._draw)
            reached = self._reached(load_policy(data, verify=False))
            if reached is not None:
                break
        named = {"policy_hash": policy_hash(data)}
        rewrite(self._log.path, out, metadata={RUN: named}, attachments={POLICY_ATTACHMENT: data})
        return Change("weight", reached, "", -1, "q_values")

    def _reached(self, other: LoadedPolicy) -> int | None:
        asked = [n for n, d in enumerate(self._ticks) if d.q_values]
        retinas = [np.frombuffer(self._ticks[n].retina, np.uint8) for n in asked]
        stack = np.array(retinas).reshape(-1, *CONTRACT.retina.stack_shape)
        differ = (other.decide(stack)[0] != self._policy.decide(stack)[0]).any(axis=1)
        return asked[int(differ.argmax())] if differ.any() else None

    def _rewrite(self, out: Path, topic: str, wanted: int, change) -> None:
        rewrite(
            self._log.path,
            out,
            lambda where, nth, data: change(data) if (where, nth) == (topic, wanted) else data,
        )


def main() -> int:
    """Forge, ask, count."""
    given = _arguments()
    missed: list[str] = []
    found: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        drive(folder / "drive.mcap", exported(CONTRACT, 3, "Relu"), nominal(TICKS), TICKS)
        forger = Forger(folder, read_log(folder / "drive.mcap"), given.seed)
        for number in range(given.count):
            forged, change = forger.forged(number)
            complaints = [
                *_by_replay(forged, change),
                *_by_diff(folder / "drive.mcap", forged, change),
            ]
            missed += [f"{number}: {change}: {complaint}" for complaint in complaints]
            found[change.kind] += not complaints
            forged.unlink()
            if number % 500 == 499:
                print(f"{number + 1} changes, {len(missed)} missed", file=sys.stderr, flush=True)
    for line in missed[:20]:
        print(line)
    print(f"{given.count} changes: {dict(found)} found and named, {len(missed)} missed")
    return int(bool(missed))


def _by_replay(forged: Path, change: Change) -> list[str]:
    """What is wrong with what replay says."""
    try:
        report = replay(forged)
    except ReflexarcError as error:  # a policy that no longer does what its contract says
        return [] if change.kind == "weight" else [f"replay refuses it: {error}"]
    if report.exit_status != 1:
        return [f"replay says {report.verdict}"]
    firsts = [level.first for level in (*report.levels, *report.commands) if level.first]
    earliest = min(first.tick for first in firsts)
    return [] if earliest == change.tick else [f"replay names tick {earliest}"]


def _by_diff(whole: Path, forged: Path, change: Change) -> list[str]:
    """What is wrong with what diff says; it compares messages, no attachments."""
    report = diff(whole, forged)
    if change.message < 0:
        return []
    differing = [topic for topic in report.topics if not topic.is_same]
    if [topic.topic for topic in differing] != [change.topic]:
        return [f"diff names {[topic.topic for topic in differing]}"]
    named = {(f.field, f.first.number) for f in differing[0].fields.values() if f.first}
    return [] if named == {(change.field, change.message)} else [f"diff names {named}"]


def _alter(message: ProtobufMessage, draw: random.Random, but: set[str]) -> str:
    """Change one field that is set; its name."""
    names = [f.name for f, _ in message.ListFields() if f.name not in but]
    name = draw.choice(names)
    value = getattr(message, name)
    if isinstance(value, str):
        setattr(message, name, value + "!")
    elif isinstance(value, bytes):
        setattr(message, name, _changed(value, draw.randrange(len(value)), draw.randrange(1, 256)))
    elif isinstance(value, int | float):
        setattr(message, name, value + draw.choice([1, 3]))
    else:
        value[draw.randrange(len(value))] += draw.choice([1e-3, 1.0, -2.0])
    return name


def _changed(data: bytes, place: int, by: int) -> bytes:
    changed = bytearray(data)
    changed[place] = (changed[place] + by) % 256
    return bytes(changed)


def _with(kind: type[Tick], data: bytes, decision: Decision) -> bytes:
    tick = kind.FromString(data)
    tick.decision.CopyFrom(decision)
    return tick.SerializeToString()


def _with_another_weight(data: bytes, draw: random.Random) -> bytes:
    model = onnx.load_from_string(data)
    floats = [t for t in model.graph.initializer if t.data_type == onnx.TensorProto.FLOAT]
    tensor = draw.choice(floats)
    array = numpy_helper.to_array(tensor).copy()
    place = draw.randrange(array.size)
    array.flat[place] = array.flat[place] * 1.5 + draw.choice([-1.0, 1.0])
    tensor.CopyFrom(numpy_helper.from_array(array, tensor.name))
    return model.SerializeToString(deterministic=True)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
