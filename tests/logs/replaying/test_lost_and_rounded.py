"""What is missing, cut or rounded is never called different; what differs always is."""

from dataclasses import replace

import numpy as np
import pytest

from reflexarc_logs.cutting.cut import cut
from reflexarc_logs.cutting.span import TickSpan, span_of
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from support.policies import exported
from support.recordings import CONTRACT, MS, PERIOD_NS, RUN, START_NS, drive, nominal, retina_at
from support.rewriting import rewrite
from support.slices import slice_by_time, times_ns

TICKS = 120
HELD = replace(CONTRACT, hold_s=0.1, margin=0.05)


def noisy(ticks: int, seed: int = 0) -> dict[int, list[Message]]:
    """Retinas without any likeness to the one before: a reflex flickers."""
    shape = (ticks, *CONTRACT.retina.shape)
    retinas = np.random.default_rng(seed).integers(0, 256, shape, np.uint8)
    return {slot: [retina_at(slot, retinas[slot - 1])] for slot in range(1, ticks + 1)}


@pytest.fixture(scope="module")
def held_log(tmp_path_factory):
    path = tmp_path_factory.mktemp("held") / "log.mcap"
    drive(path, exported(HELD, 3, "Relu"), noisy(TICKS), TICKS)
    return path


def test_a_listener_that_missed_ticks_is_not_called_different(held_log, tmp_path):
    for first in range(10, 100, 7):
        lost = range(first, first + 5)
        path = tmp_path / f"{first}.mcap"

        def forget(topic, number, payload, lost=lost):
            return None if topic.endswith("/tick") and number in lost else payload

        rewrite(held_log, path, forget, metadata={"reflexarc.run": {"recorded_by": "record"}})
        assert replay(path).exit_status == 0


@pytest.mark.parametrize("after_ns", [0, 1, 3 * MS, 3 * MS + 1, 20 * MS, 23 * MS])
def test_a_slice_that_begins_within_the_first_ticks_replays(after_ns, held_log, tmp_path):
    earliest_ns, latest_ns = times_ns(held_log)
    part = slice_by_time(held_log, tmp_path / "part.mcap", earliest_ns + after_ns, latest_ns + 1)
    assert replay(part).exit_status == 0
    again = cut(read_log(part), span_of(read_log(part)), tmp_path / "again.mcap")
    assert replay(again.path).exit_status == 0


def test_what_a_log_says_is_missing_is_missing_in_its_parts(held_log, tmp_path):
    path = tmp_path / "log.mcap"
    rewrite(held_log, path, metadata={"reflexarc.end": {"dropped": "2"}})
    part = cut(read_log(path), TickSpan(20, 60), tmp_path / "part.mcap")
    assert read_log(part.path).dropped == 2
    assert [level.level for level in replay(part.path).levels] == ["policy"]


def test_a_log_whose_channels_name_no_sender_replays(held_log, tmp_path):
    assert replay(rewrite(held_log, tmp_path / "log.mcap")).exit_status == 0


@pytest.mark.parametrize("hold_s", [0.0, 0.06, 0.3])
@pytest.mark.parametrize("margin", [0.0, 0.2])
def test_rounding_between_backends_is_judged_where_it_arises(hold_s, margin, tmp_path):
    """Two outputs are almost the same, so each backend often prefers another one."""
    contract = replace(CONTRACT, hold_s=hold_s, margin=margin)
    path = tmp_path / "log.mcap"
    drive(path, almost_tied(contract), noisy(300), 300, run=replace(RUN, backend="onnxruntime"))
    report = replay(path, backend="numpy")
    assert report.exit_status == 0, report.lines()
    assert sum(len(level.flips) for level in report.levels) >= 10
    assert all(flip.rounding for level in report.levels for flip in level.flips)


def almost_tied(contract):
    from support.networks import with_honest_vectors, with_weights

    def twin(array: np.ndarray) -> None:
        array[:] = array[:1]
        array[1] *= np.float32(1 + 2e-7)

    policy = exported(contract, 3, "Relu")
    return with_honest_vectors(with_weights(with_weights(policy, "w2", twin), "b2", twin))


@pytest.mark.parametrize("size", [70_000, 2_000_000])
@pytest.mark.parametrize("kind", ["stop", "reset"])
def test_a_control_message_of_any_size_and_kind_replays(size, kind, tmp_path):
    schedule = nominal(TICKS)
    at_ns = START_NS + 40 * PERIOD_NS - MS
    stamp = pack_stamp(Stamp(0, at_ns))
    text = protobuf_encoding("text")
    schedule[40] = [*schedule[40], Message(f"robot0/{kind}", b"x" * size, text, stamp, at_ns)]
    drive(tmp_path / "log.mcap", exported(CONTRACT, 3, "Relu"), schedule, TICKS)
    assert replay(tmp_path / "log.mcap").exit_status == 0


def test_a_part_without_a_tick_is_refused_and_leaves_nothing(held_log, tmp_path):
    with pytest.raises(LogError, match="no tick"):
        cut(read_log(held_log), TickSpan(500, 600), tmp_path / "part.mcap")
    assert not list(tmp_path.iterdir())
