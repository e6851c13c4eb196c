"""Modules load without the collector; afterwards it is as it was."""

import gc
import subprocess
import sys

from reflexarc.loading import uncollected


def test_the_collector_rests_inside_and_is_as_it_was_afterwards():
    with uncollected():
        assert not gc.isenabled()
    assert gc.isenabled()
    gc.disable()
    try:
        with uncollected():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_a_run_without_a_recording_loads_no_recorder():
    words = """
import sys
import reflexarc.wiring.running.sense_act_loop
from reflexarc.wiring.keeping_logs.run_sinks import RunSinks
assert not RunSinks().takes_any and RunSinks().recordings["recording"].state == "off"
print(*(name for name in sys.modules if name.startswith("reflexarc_logs.recording.rec")), end="")
"""
    said = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True)
    assert (said.returncode, said.stdout, said.stderr) == (0, "", "")
