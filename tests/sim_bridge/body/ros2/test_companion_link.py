import os
import signal

import pytest

from reflexarc_runtime.errors import BusError
from reflexarc_sim_bridge.body.ros2.companion import Watched
from reflexarc_sim_bridge.body.ros2.companion_link import CompanionLink
from support.ros2_drives import lives
from support.ros2_robot import free_port


def watched(zenoh: str = "") -> Watched:
    return Watched("robot0", free_port(), zenoh, "cmd_vel", False, "ab" * 16, 20_000_000)


def test_a_companion_lives_in_a_session_of_its_own_and_ends_with_a_farewell():
    with CompanionLink(watched()) as link:
        assert link.is_alive()
        assert os.getsid(link.process_id) == link.process_id != os.getsid(0)
    assert not lives(link.process_id)


def test_a_companion_that_was_killed_is_missed_once(caplog: pytest.LogCaptureFixture):
    with CompanionLink(watched()) as link:
        os.kill(link.process_id, signal.SIGKILL)
        os.waitid(os.P_PID, link.process_id, os.WEXITED | os.WNOWAIT)
        assert not link.is_alive()
        assert not link.is_alive()
    assert len(caplog.records) == 1
    assert "nobody watches the twists" in caplog.text


def test_a_companion_that_does_not_start_is_refused(capfd: pytest.CaptureFixture[str]):
    with pytest.raises(BusError, match="--no-companion"):
        CompanionLink(watched(zenoh="/nowhere/none.json5"))
    assert "no such file" in capfd.readouterr().err
