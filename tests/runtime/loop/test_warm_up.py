"""After the first tick the loop's thread imports nothing and opens nothing."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[2]
"""Where the support package is: a process of its own does not know pytest's path."""

LISTENER = """
import json, sys, threading
loop, heard, is_on = threading.current_thread(), [], False
def listen(event, details):
    if is_on and event in ("import", "open") and threading.current_thread() is loop:
        heard.append(f"{event} {details[0]}")
sys.addaudithook(listen)

import numpy as np
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.outlets import Outlets
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_runtime.sensing.senses import sense_for
from support.policies import SMALL, exported

kind, backend, opens = sys.argv[1], sys.argv[2], sys.argv[3] == "opens"

def sensed(number, now_ns):
    if number % 10 == 7:
        return b"\\xff", "text/plain"
    if kind == "scan":
        scan = LaserScan(start_angle=-3.1, end_angle=3.1, ranges=[1.0, float("inf")] * 90)
        return scan.SerializeToString(), protobuf_encoding("foxglove.LaserScan")
    retina = np.full(SMALL.retina.shape, 9, np.uint8)
    payload = encode_retina(retina, SMALL.retina, now_ns)
    return payload, protobuf_encoding("foxglove.RawImage")

class Feeding(ManualClock):
    count = 0
    def sleep_until_ns(self, deadline_ns):
        global is_on
        super().sleep_until_ns(deadline_ns)
        is_on = False
        payload, encoding = sensed(self.count, deadline_ns)
        stamp = pack_stamp(Stamp(self.count, deadline_ns, b"b" * 16))
        inbox.put(Message(f"robot0/{kind}", payload, encoding, stamp, deadline_ns))
        self.count += 1
        is_on = self.count > 1

class Nowhere:
    def put(self, payload, time_ns):
        if opens:
            open("/dev/null").close()

inbox = Inbox()
policy = load_policy(exported(SMALL), backend)
controller = Controller(policy, SMALL, sense_for(kind, SMALL.retina), "hash")
outlets = Outlets(Nowhere(), Nowhere(), Nowhere())
verdicts = Node(controller, RatePacer(50.0, Feeding(), inbox), outlets).run(max_ticks=120).verdicts
is_on = False
print(json.dumps([heard, verdicts]))
"""
"""A run of two seconds and two statuses on a clock that moves by itself."""


def heard(*words: str) -> list[str]:
    program = f"import sys; sys.path.insert(0, {str(TESTS)!r})\n{LISTENER}"
    done = subprocess.run(
        [sys.executable, "-c", program, *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    events, verdicts = json.loads(done.stdout)
    assert {"OK", "INVALID_INPUT", "RECOVERING", "STOPPED"} <= set(verdicts)
    return [str(event) for event in events]


@pytest.mark.parametrize("backend", ["numpy", "onnxruntime"])
@pytest.mark.parametrize("kind", ["retina", "scan"])
def test_nothing_is_imported_or_opened_in_the_loop(kind: str, backend: str):
    assert heard(kind, backend, "as it is") == []


def test_a_loop_that_opens_a_file_is_heard():
    assert any(event.startswith("open") for event in heard("retina", "numpy", "opens"))
