"""One definition of a retina: the same scan gives the same bytes wherever it is read."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan

from reflexarc_logs.container.rejected import accepted_message
from reflexarc_logs.importing.lidar_import import import_log
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.messages.wire import Message, Stamp
from reflexarc_runtime.sensing.ray_values import ray_bearing_rad
from reflexarc_runtime.sensing.retina import retina_from_scan
from reflexarc_runtime.sensing.scan import Scan
from reflexarc_runtime.sensing.senses import ScanSense
from support.lidar import (
    CARMEN,
    CORESLAM_SPAN_RAD,
    carmen_file,
    carmen_span_rad,
    coreslam_file,
    slow_carmen,
    slow_coreslam,
    slow_retinas,
)
from support.policies import exported
from support.recordings import CONTRACT, MS, PERIOD_NS, RUN, START_NS, drive

EYES = [
    RetinaSpec(rays=16, fov_rad=math.pi, range_m=5.0),
    RetinaSpec(rays=45, fov_rad=0.99 * math.pi, range_m=12.0),
]
STEPS = 60


@pytest.mark.parametrize("spec", EYES)
@pytest.mark.parametrize("name", CARMEN)
def test_every_real_scan_gives_the_retina_of_the_definition(
    tmp_path: Path, name: str, spec: RetinaSpec
):
    import_log(carmen_file(name), tmp_path / "out.mcap", "carmen")
    ranges = np.array([ranges for ranges, _, _ in slow_carmen(carmen_file(name))])
    span_rad = carmen_span_rad(ranges.shape[1])
    expected = slow_retinas(ranges, span_rad, spec.rays, spec.fov_rad, spec.range_m)
    assert_rounded(retinas_of(tmp_path / "out.mcap", spec), expected)


@pytest.mark.parametrize("spec", EYES)
def test_every_real_scan_of_a_hokuyo_gives_the_retina_of_the_definition(
    tmp_path: Path, spec: RetinaSpec
):
    import_log(coreslam_file(), tmp_path / "out.mcap", "coreslam")
    _, numbers = slow_coreslam(coreslam_file())
    ranges = np.where(numbers == 0, np.inf, np.where(numbers < 20, np.nan, numbers / 1000))
    expected = slow_retinas(ranges, CORESLAM_SPAN_RAD, spec.rays, spec.fov_rad, spec.range_m)
    assert_rounded(retinas_of(tmp_path / "out.mcap", spec), expected)


def assert_rounded(values: npt.NDArray[np.uint8], exact: npt.NDArray[np.float64]) -> None:
    """Each value is the nearest one; centimetres make exact halves, which may go either way."""
    assert values.shape == exact.shape
    assert np.abs(values - exact).max() <= 0.5 + 1e-9
    assert len(np.unique(values)) > 100


def retinas_of(path: Path, spec: RetinaSpec) -> npt.NDArray[np.uint8]:
    """Retinas (n, rays) by the sense of the runtime."""
    sense = ScanSense(spec)
    records = read_log(path).records("/robot0/scan")
    return np.array([sense.decode(message_of(r.payload, 0)).retina.ravel() for r in records])


def message_of(payload: bytes, slot: int) -> Message:
    """The scan that arrives 3 ms before the deadline of a slot."""
    received_ns = START_NS + slot * PERIOD_NS - 3 * MS
    stamp = Stamp(slot, received_ns)
    return accepted_message("robot0/scan", "foxglove.LaserScan", payload, stamp, received_ns)


def test_simulator_bus_and_replay_give_the_same_bytes_for_the_same_scan(tmp_path: Path):
    scans, expected = simulated(CONTRACT)
    direct = [retina_from_scan(scan, CONTRACT.retina).tobytes() for scan in scans]
    assert direct == expected
    schedule = {slot: [message_of(payload_of(s), slot)] for slot, s in enumerate(scans, 1)}
    path = tmp_path / "drive.mcap"
    drive(path, exported(CONTRACT), schedule, STEPS, run=replace(RUN, input="scan"))
    decisions = [tick.decision for tick in read_log(path).ticks()]
    assert [d.retina for d in decisions[2:-1]] == expected[2:]  # two go into recovering
    assert replay(path).exit_status == 0
    assert len(set(expected)) > STEPS / 2


def simulated(contract: PolicyContract) -> tuple[list[Scan], list[bytes]]:
    """What a simulated eye meets, as scans, and what it sees, as bytes; all things are white."""
    from reflexarc_sim_bridge.simulation.simulation import Simulation
    from reflexarc_sim_bridge.worlds.files import world_named

    simulation = Simulation(world_named("mixed"), contract, np.array([3], np.uint64))
    scans, seen = [], []
    for _ in range(STEPS):
        simulation.step(np.array([0], np.int64))
        seen.append(simulation.sense()[0].tobytes())
        scans.append(scan_of(simulation.distances(), contract.retina))
    return scans, seen


def scan_of(distances_m: npt.NDArray[np.float32], spec: RetinaSpec) -> Scan:
    """Distances by ray (leftmost first) as a scan with one beam a ray."""
    edge_rad = ray_bearing_rad(0, spec.rays, spec.fov_rad)
    ranges_m = distances_m[::-1].astype(np.float64)
    return Scan(-edge_rad, edge_rad, np.where(ranges_m >= spec.range_m, np.inf, ranges_m))


def payload_of(scan: Scan) -> bytes:
    message = LaserScan(
        start_angle=scan.start_rad, end_angle=scan.end_rad, ranges=scan.ranges_m.tolist()
    )
    return message.SerializeToString()
