"""A contact of a recorded drive is rebuilt to the bit, and driven again."""

import json
import signal
from pathlib import Path

from reflexarc_logs.reading.reader import read_log
from reflexarc_runtime.messages_pb2 import Contact
from support.processes import finished, reflexarc, started


def test_a_contact_happens_again_at_its_tick_and_the_control_never_leaves_its_way(
    policy: Path, port: int, tmp_path: Path
):
    log = tmp_path / "drive.mcap"
    words = ("run", policy, "--no-guard", "--lockstep", "--port", port, "--record", log, "--json")
    sim = ("sim", "--world", "tier-30", "--seed", 3, "--steps", 150)
    with started(*words) as runtime, started(*sim, "--lockstep", "--port", port, "--json") as body:
        finished(body)
        finished(runtime, signal.SIGINT)
    # In lockstep the state after step n has the time n · period: the tick before it is n − 1.
    read = read_log(log)
    touched = [r.publish_ns // 20_000_000 - 1 for r, _ in read.messages("/robot0/contact", Contact)]
    assert touched

    said = reflexarc("replay", log, "--drive", "--json")
    found = json.loads(said.stdout)["logs"][0]
    assert said.returncode == 1
    assert found["off_tick"] is None
    assert sorted([one["tick"] for one in found["tried"]] + found["too_late"]) == touched
    for one in found["tried"]:
        assert one["recorded"]["contact_tick"] == one["candidate"]["contact_tick"] == one["tick"]
        assert one["leaves_tick"] is None

    text = reflexarc("replay", log, "--drive", "--first", "contact")
    assert f"contact at tick {touched[0]}: recorded policy touches at tick {touched[0]} again" in (
        text.stdout
    )
