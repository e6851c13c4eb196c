"""What tracks say, by hand; how a sensor keeps time."""

import time
from pathlib import Path

import numpy as np
import pytest
from frameworks import save_network
from three_roles import measures, roles

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.policy.policy import load_policy
from support.policies import exported

MS = 1_000_000
DRIVES, STOPS = 1, 0


def commands(*rows: tuple[float, float, int]) -> measures.Rows:
    """Commands by the times of arrival and of the retina, in milliseconds."""
    return np.array([(a * MS, sent * MS, drives) for a, sent, drives in rows], np.int64)


def test_latency_counts_the_first_command_of_each_retina_sent_in_the_span() -> None:
    heard = commands((11, 10, 1), (13, 10, 1), (15, 12, 1), (22, 20, 1))
    assert measures.latencies_ns(heard, 10 * MS, 20 * MS).tolist() == [1 * MS, 3 * MS]


def test_latency_does_not_count_safe_commands_which_name_no_retina() -> None:
    heard = commands((11, 0, 0), (15, 12, 1))
    assert measures.latencies_ns(heard, 1, 20 * MS).tolist() == [3 * MS]


def test_unsteadiness_is_what_gaps_differ_by_both_ways() -> None:
    heard = commands((10, 0, 1), (30, 0, 1), (55, 0, 1), (70, 0, 1))
    assert measures.unsteadiness_ns(heard, 20 * MS).tolist() == [0, 5 * MS, 5 * MS]


def test_a_body_without_commands_stands_after_its_patience() -> None:
    heard = commands((10, 5, DRIVES), (30, 25, DRIVES))
    assert measures.standstill_ns(heard, 40 * MS, 1000 * MS) == 90 * MS


def test_a_body_stands_at_the_first_command_to_stop() -> None:
    heard = commands((10, 5, DRIVES), (30, 25, DRIVES), (50, 0, STOPS), (70, 0, STOPS))
    assert measures.standstill_ns(heard, 40 * MS, 1000 * MS) == 10 * MS


def test_a_stop_before_another_drive_command_is_no_standstill_for_good() -> None:
    heard = commands((10, 5, DRIVES), (50, 0, STOPS), (60, 5, DRIVES), (90, 0, STOPS))
    assert measures.standstill_ns(heard, 40 * MS, 1000 * MS) == 50 * MS


def test_a_stop_later_than_the_patience_stops_nothing_earlier() -> None:
    heard = commands((30, 25, DRIVES), (200, 0, STOPS))
    assert measures.standstill_ns(heard, 40 * MS, 1000 * MS) == 90 * MS


def test_a_body_that_is_told_to_drive_until_the_end_never_stands() -> None:
    heard = commands(*[(n, 5, DRIVES) for n in range(10, 1000, 20)])
    assert measures.standstill_ns(heard, 40 * MS, 1000 * MS) is None


@pytest.mark.parametrize("stands_at", [20, 39])
def test_a_body_that_stood_before_took_no_time(stands_at: int) -> None:
    heard = commands((10, 5, DRIVES), (stands_at, 0, STOPS))
    assert measures.standstill_ns(heard, 40 * MS, 1000 * MS) == 0


def test_rows_that_were_never_written_do_not_count() -> None:
    track = np.zeros((5, 3), np.int64)
    track[0] = (7, 0, 1)
    assert measures.written(track).tolist() == [[7, 0, 1]]


def retina(picture: bytes, sent_ns: int) -> bytes:
    return roles.RETINA.pack(3, sent_ns, picture)


def brain(folder: Path, most_age_ns: int = 0) -> roles.Brain:
    save_network(exported(PolicyContract(), seed=5, activation="Relu"), folder)
    return roles.Brain(folder, most_age_ns)


def action(mind: roles.Brain) -> int:
    command = mind.decide()
    assert command is not None
    return int(roles.COMMAND.unpack(command)[2])


def test_a_brain_decides_as_the_policy_of_ours_does(tmp_path: Path) -> None:
    mind, policy = brain(tmp_path), load_policy(exported(PolicyContract(), 5, "Relu"))
    pictures = np.random.default_rng(3).integers(0, 256, (50, 16), dtype=np.uint8)
    _, expected = policy.decide(pictures.reshape(50, *PolicyContract().retina.stack_shape))
    found = []
    for picture in pictures:
        mind.see(retina(picture.tobytes(), 1))
        found.append(action(mind))
    assert found == expected.tolist()
    assert len(set(found)) > 1


def test_a_brain_without_a_retina_says_nothing(tmp_path: Path) -> None:
    assert brain(tmp_path).decide() is None


def test_only_a_brain_that_looks_at_the_age_stops_on_an_old_retina(tmp_path: Path) -> None:
    for most_age_ns, stops in ((0, False), (100 * MS, True)):
        mind = brain(tmp_path, most_age_ns)
        mind.see(retina(roles.PICTURE, time.monotonic_ns() - 200 * MS))
        assert (action(mind) == roles.STOP) is stops
        mind.see(retina(roles.PICTURE, time.monotonic_ns()))
        assert action(mind) != roles.STOP


def test_a_brain_that_lost_its_sensor_stops(tmp_path: Path) -> None:
    mind = brain(tmp_path)
    mind.see(retina(roles.PICTURE, time.monotonic_ns()))
    mind.lost_sensor = True
    assert action(mind) == roles.STOP


class EnoughError(Exception):
    """The sensor has sent enough."""


def test_a_sensor_keeps_its_times_and_leaves_out_those_it_missed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now_ns, sent = [1000 * MS], []

    def sleep(seconds: float) -> None:
        now_ns[0] += round(seconds * 1e9)

    def send(payload: bytes) -> None:
        number, sent_ns, _ = roles.RETINA.unpack(payload)
        sent.append((number, sent_ns // MS))
        now_ns[0] += {2: 47, 5: 20}.get(number, 3) * MS  # it hangs twice
        if number == 7:
            raise EnoughError

    monkeypatch.setattr(roles.time, "monotonic_ns", lambda: now_ns[0])
    monkeypatch.setattr(roles.time, "sleep", sleep)
    with pytest.raises(EnoughError):
        roles.send_retinas(send, 20 * MS)
    assert sent == [*zip(range(8), (1000, 1020, 1040, 1100, 1120, 1140, 1160, 1180), strict=True)]
