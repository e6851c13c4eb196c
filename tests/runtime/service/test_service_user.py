"""What a user may reach: beside what the kernel lets a process of that user do."""

import itertools
import os
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.service.service_user import ENTER, READ, WRITE, ServiceUser, service_user_of

MADE_BY_SYSTEMD = 61184
"""The first number that systemd gives to a user that it makes: systemd.exec(5), DynamicUser=."""
SOMEBODY = 1234
as_root = pytest.mark.skipif(os.getuid() != 0, reason="only root can become somebody else")


@pytest.fixture
def folder() -> Iterator[Path]:
    """Where everybody gets to, unlike the folders of tests."""
    with TemporaryDirectory(dir="/var/lib", prefix="reflexarc-test-") as made:
        Path(made).chmod(0o755)
        yield Path(made)


def kernel_lets(uid: int, groups: list[int], path: Path, wanted: int) -> bool:
    """Whether this user may, by access(2)."""
    before = os.getgroups()
    os.setgroups(groups)
    os.setegid(uid)
    os.seteuid(uid)
    try:
        return os.access(path, wanted, effective_ids=True)
    finally:
        os.seteuid(0)
        os.setegid(0)
        os.setgroups(before)


@as_root
@pytest.mark.parametrize(
    ("user", "uid", "groups"),
    [
        (ServiceUser(), MADE_BY_SYSTEMD, []),
        (ServiceUser("member", SOMEBODY, frozenset({77})), SOMEBODY, [77]),
        (ServiceUser("owner", 55, frozenset({55})), 55, []),
    ],
)
def test_it_says_what_the_kernel_says(user, uid, groups, folder):
    """All ways in which a folder and a file in it can be closed to owner, group and others."""
    file = folder / "file"
    file.touch()
    os.chown(folder, 55, 77)
    os.chown(file, 55, 77)
    seen = set()
    for above, mode in itertools.product((0o700, 0o710, 0o750, 0o711), range(0, 0o1000, 3)):
        folder.chmod(above)
        file.chmod(mode)
        for wanted in (READ, READ | ENTER, WRITE):
            lets = kernel_lets(uid, groups, file, wanted)
            assert (user.obstacle(file, wanted) == "") is lets, oct(mode)
            seen.add(lets)
    assert seen == {True, False}


@as_root
def test_a_folder_on_the_way_of_a_link_counts(folder):
    shut = folder / "shut"
    shut.mkdir(mode=0o700)
    (shut / "python").touch(mode=0o755)
    (folder / "python").symlink_to(shut / "python")
    assert f"{shut} is closed" in ServiceUser().obstacle(folder / "python", READ)


def test_what_is_not_there_is_an_obstacle(tmp_path: Path):
    assert "no such file" in service_user_of(str(os.getuid())).obstacle(tmp_path / "none", READ)
    assert service_user_of("").obstacle(Path("/etc/passwd"), READ) == ""
    assert "/etc/passwd is closed" in service_user_of("").obstacle(Path("/etc/passwd"), WRITE)


@pytest.mark.parametrize("user", ["no-such-user", "4294967290", "99999999999999"])
def test_an_unknown_user_is_said(user: str):
    with pytest.raises(UsageError, match="--user: expected a user of this machine"):
        service_user_of(user)
