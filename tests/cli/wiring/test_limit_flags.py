from pathlib import Path

import pytest

from reflexarc.wiring.limit_flags import LimitFlags
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.errors import ReflexarcError, UsageError

FILE = """
[limits]
linear_mps = 0.5
lateral_mps = 0.0
angular_radps = 1.5
valid_for_s = 0.3
"""


def limits_file(folder: Path, text: str = FILE) -> Path:
    path = folder / "robot.toml"
    path.write_text(text)
    return path


def test_flags_alone_say_what_a_robot_does_at_most():
    flags = LimitFlags(0.5, 0.0, 1.5, max_acceleration=1.0, max_validity=0.2)
    assert flags.body_limits() == BodyLimits(0.5, 0.0, 1.5, 1.0, 0.2)


def test_a_file_alone_says_it(tmp_path: Path):
    expected = BodyLimits(0.5, 0.0, 1.5, valid_for_s=0.3)
    assert LimitFlags(limits=limits_file(tmp_path)).body_limits() == expected


def test_a_flag_narrows_a_file_and_never_widens_it(tmp_path: Path):
    flags = LimitFlags(max_linear=0.2, max_angular=9.0, limits=limits_file(tmp_path))
    assert flags.body_limits() == BodyLimits(0.2, 0.0, 1.5, valid_for_s=0.3)


def test_a_speed_that_nothing_limits_is_refused(tmp_path: Path):
    path = limits_file(tmp_path, "[limits]\nlinear_mps = 0.5\nlateral_mps = 0.0\n")
    with pytest.raises(UsageError, match="got no --max-angular"):
        LimitFlags(limits=path).body_limits()


@pytest.mark.parametrize("line", ["linear_mps = -1.0", "linear_mps = nan", "speed = 1.0"])
def test_what_is_no_limit_is_told_with_its_line(tmp_path: Path, line: str):
    path = limits_file(tmp_path, f"[limits]\n{line}\n")
    with pytest.raises(ReflexarcError, match=r"robot\.toml:2"):
        LimitFlags(limits=path).body_limits()
