"""The timer that ends a process whose loop hangs, in processes of their own."""

import signal
import subprocess
import sys

HANGS = """
import threading, time
from reflexarc_runtime.loop.kernel_timer import KernelTimer

def beside_the_loop():
    while True:
        time.sleep(0.001)

def the_loop():
    while True:
        pass

threading.Thread(target=beside_the_loop, daemon=True).start()
with KernelTimer(0.1) as timer:
    timer.wind(1 << 40)
    the_loop()
"""


def test_a_process_that_hangs_ends_and_says_where_its_loop_was_and_looks_at_no_other_thread():
    done = subprocess.run(
        [sys.executable, "-c", HANGS], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == -signal.SIGALRM
    assert "in the_loop" in done.stderr
    assert "beside_the_loop" not in done.stderr  # it runs: its frames may change under the look
