"""What programs read of a fleet."""

import json

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.fleet.as_json import fleet_as_dict
from reflexarc_runtime.fleet.fleet import Fleet
from support.fleet_words import BODY, FIRST, SECOND, lease, status


def test_robots_runtimes_and_bodies_have_the_documented_keys():
    fleet = Fleet()
    phase = pb.PhaseTimes(phase="picture age", count=50, p50_ns=9_000_000, p99_ns=21_000_000)
    fleet.hear(
        status("rover", verdict=pb.OK, rate_hz=50.0, ticks=9, verdicts={"OK": 9}, phases=[phase])
    )
    fleet.hear(lease("rover", holder=FIRST, epoch=2, armed=True, state="driving", body=BODY))
    fleet.announced("rover/alive/body", 0, is_there=True)
    said = fleet_as_dict(fleet.view(SECOND // 4))
    assert json.loads(json.dumps(said)) == said
    (robot,) = said["robots"]
    (runtime,), (body,) = robot["runtimes"], robot["bodies"]
    assert (robot["robot"], robot["nodes"]) == ("rover", ["body"])
    assert set(runtime) == {
        *("id", "run_id", "age_s", "state", "holds_lease", "rate_hz", "contract_rate_hz", "pace"),
        *("ticks", "skipped_slots", "inbox_overflows", "verdict", "verdicts", "period_verdicts"),
        *("action", "policy", "policy_hash", "guard", "recording", "watchdog", "sensor", "shadow"),
        "phases",
    }
    assert (runtime["id"], runtime["age_s"], runtime["state"]) == ("a1a1a1a1", 0.25, "live")
    assert (runtime["holds_lease"], runtime["verdicts"]) == (True, {"OK": 9})
    assert runtime["phases"]["picture_age"]["p99_s"] == 0.021
    assert body == {
        "id": "c3c3c3c3",
        "age_s": 0.25,
        "state": "live",
        "lease": "driving",
        "holder": "a1a1a1a1",
        "epoch": 2,
        "armed": True,
        "stopped": "",
        "refused": {},
        "guard": "",
    }
    assert said["totals"] == {
        "robots": 1,
        "runtimes": 1,
        "bodies": 1,
        "armed": 1,
        "holding": 1,
        "rate_hz": 50.0,
        "silent": 0,
        "unreadable": 0,
        "left_out": 0,
    }
