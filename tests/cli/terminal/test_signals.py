import os
import signal

import pytest

from reflexarc.terminal.signals import ENDINGS, StopFlag


@pytest.mark.parametrize("number", ENDINGS)
def test_every_signal_that_asks_for_an_end_is_a_flag(number: signal.Signals):
    before = signal.getsignal(number)
    with StopFlag() as stop:
        assert not stop()
        os.kill(os.getpid(), number)
        assert stop()
    assert signal.getsignal(number) is before


def test_what_is_ignored_as_under_nohup_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with StopFlag() as stop:
            os.kill(os.getpid(), signal.SIGHUP)
            assert not stop()
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)
