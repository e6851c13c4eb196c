import stat
from base64 import b64decode
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("cryptography")

from cryptography import x509
from cryptography.hazmat.primitives import serialization

from reflexarc.securing import security_folder
from reflexarc.securing.secured_robot import SecuredRobot
from reflexarc.securing.security_folder import SecurityFolder, make_folder, renew
from reflexarc.securing.variants import settings_of
from reflexarc_runtime.bus import settings_of_file
from reflexarc_runtime.doors.open_doors import open_doors
from reflexarc_runtime.errors import UsageError

ROBOT = SecuredRobot("robot0", ("10.0.0.1",), 7447, "body", 365.0)


ROS_RULE = """{ id: 'ROS 2', messages: ["put"], flows: ["egress"], permission: "allow",
 key_exprs: ["rt/cmd_vel"], }"""


def certificate_in(text: str) -> str:
    return text.partition('"connect_certificate_base64": "')[2].partition('"')[0]


def names(folder: Path) -> set[str]:
    return {file.name for file in folder.iterdir()}


def test_it_is_for_its_owner_alone(tmp_path: Path):
    folder = make_folder(tmp_path / "new" / "keys", ROBOT)
    assert stat.S_IMODE(folder.path.stat().st_mode) == 0o700
    secret = {"ca.key", *(f"{role}.json5" for role in ROBOT.roles)}
    assert {file.name for file in folder.secrets} == secret
    assert {stat.S_IMODE(file.stat().st_mode) for file in folder.secrets} == {0o600}
    assert names(tmp_path / "new") == {"keys"}
    assert folder.readable_by_others() == []
    folder.file("viewer").chmod(0o640)
    assert folder.readable_by_others() == ["viewer.json5"]


def test_nothing_is_overwritten(tmp_path: Path):
    (tmp_path / "keys").mkdir()
    (tmp_path / "file").touch()
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    for name in ("keys", "file", "link"):
        with pytest.raises(UsageError, match="nothing is overwritten"):
            make_folder(tmp_path / name, ROBOT)
    assert names(tmp_path) == {"keys", "file", "link"}


def test_it_is_whole_or_absent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    real, written = security_folder.role_text, []

    def third_fails(*words: object) -> str:
        written.append(1)
        if len(written) == 3:
            raise OSError(28, "No space left on device")
        return real(*words)  # type: ignore[arg-type]  # passed on

    monkeypatch.setattr(security_folder, "role_text", third_fails)
    with pytest.raises(OSError, match="No space"):
        make_folder(tmp_path / "keys", ROBOT)
    assert names(tmp_path) == set()


@pytest.mark.parametrize("door", ["body", "router"])
@pytest.mark.parametrize("hosts", [(), ("10.0.0.1", "::1", "rover1.local"), ("rover1.local",)])
def test_zenoh_takes_every_file_and_no_door_of_them_is_open(
    hosts: tuple[str, ...], door: str, tmp_path: Path
):
    secured = replace(ROBOT, hosts=hosts, door=door)
    folder = make_folder(tmp_path / "keys", secured)
    for role in secured.roles:
        setting = settings_of_file(folder.file(role))
        assert open_doors(setting) == []
        assert setting("access_control/enabled") is (role == door)
        assert setting("scouting/gossip/enabled") is False
        assert (setting("mode") == "router") == (role == door)


def test_the_door_is_at_its_addresses_or_everywhere_if_it_has_but_names():
    assert ROBOT.listeners == ["tls/127.0.0.1:7447", "tls/10.0.0.1:7447"]
    both = replace(ROBOT, hosts=("rover1.local", "fd00::1"))
    assert both.listeners == ["tls/127.0.0.1:7447", "tls/[fd00::1]:7447"]
    assert replace(ROBOT, hosts=("rover1.local",)).listeners == ["tls/0.0.0.0:7447"]
    for alone in ((), ("localhost",), ("127.0.0.1",)):
        assert replace(ROBOT, hosts=alone).listeners == ["tls/127.0.0.1:7447"]
    assert both.doors[1:] == ["tls/rover1.local:7447", "tls/[fd00::1]:7447"]


def test_a_renewal_is_by_the_same_authority_and_of_whom_it_is_asked_for(tmp_path: Path):
    folder = make_folder(tmp_path / "keys", ROBOT)
    before = {role: folder.file(role).read_text() for role in ROBOT.roles}
    known = folder.known
    assert renew(folder, None, ["viewer"]) == [folder.file("viewer")]
    after = {role: folder.file(role).read_text() for role in ROBOT.roles}
    assert [role for role in ROBOT.roles if before[role] != after[role]] == ["viewer"]
    assert len(renew(folder, 30.0)) == len(ROBOT.roles)
    assert folder.known == known
    assert stat.S_IMODE(folder.file("body").stat().st_mode) == 0o600
    assert settings_of(folder, "body")["listen"] == {"endpoints": ROBOT.listeners}
    with pytest.raises(UsageError, match="--role"):
        renew(folder, None, ["king"])
    (folder.path / "ca.key").unlink()
    with pytest.raises(UsageError, match=r"ca\.key"):
        renew(folder, None)


@pytest.mark.parametrize("door", ["body", "router"])
def test_a_renewal_leaves_all_else_as_it_stands(door: str, tmp_path: Path):
    """The rights of ROS 2 are added by hand, as docs/secure.md says; Zenoh reads the result."""
    folder = make_folder(tmp_path / "keys", replace(ROBOT, door=door))
    file = folder.file(door)
    before = file.read_text()
    by_hand = before.replace('"rules": [', '"rules": [ /* of ROS 2 */ ' + ROS_RULE + ",", 1)
    assert by_hand != before
    file.write_text(by_hand)
    renew(folder, None)
    after = file.read_text()
    lines = zip(by_hand.splitlines(), after.splitlines(), strict=True)
    changed = [old.split('"')[1] for old, new in lines if old != new]
    assert sorted(changed) == [
        "connect_certificate_base64",
        "connect_private_key_base64",
        "listen_certificate_base64",
        "listen_private_key_base64",
    ]
    rules = settings_of_file(file)("access_control/rules")
    assert rules[0]["id"] == "ROS 2"
    assert certificate_in(after) not in by_hand
    assert stat.S_IMODE(file.stat().st_mode) == 0o600


def test_a_renewed_certificate_goes_with_its_key(tmp_path: Path):
    folder = make_folder(tmp_path / "keys", ROBOT)
    folder.file("viewer").unlink()  # it is made again
    renew(folder, None)
    for role in ROBOT.roles:
        tls = settings_of(folder, role)["transport"]["link"]["tls"]
        for side in ("connect", "listen") if role == "body" else ("connect",):
            pem = {p: b64decode(tls[f"{side}_{p}_base64"]) for p in ("certificate", "private_key")}
            key = serialization.load_pem_private_key(pem["private_key"], None)
            certificate = x509.load_pem_x509_certificate(pem["certificate"])
            assert key.public_key() == certificate.public_key()


@pytest.mark.parametrize("spoil", ["twice", "never"])
def test_a_file_that_cannot_be_renewed_is_told_and_none_is(spoil: str, tmp_path: Path):
    folder = make_folder(tmp_path / "keys", ROBOT)
    file = folder.file("viewer")
    name = '"connect_certificate_base64"'
    text = file.read_text()
    more = f'// {name}: "QUJD"\n'
    file.write_text(text + more if spoil == "twice" else text.replace(name, '"elsewhere"'))
    before = {role: folder.file(role).read_bytes() for role in ROBOT.roles}
    with pytest.raises(
        UsageError, match=r"viewer\.json5: expected connect_certificate_base64 once"
    ):
        renew(folder, None)
    assert {role: folder.file(role).read_bytes() for role in ROBOT.roles} == before


def test_a_folder_that_is_none_is_said(tmp_path: Path):
    with pytest.raises(UsageError, match="secure init"):
        SecurityFolder(tmp_path / "none").secured()
    (tmp_path / "secured.json").write_text("[]")
    with pytest.raises(UsageError, match=r"secured\.json"):
        SecurityFolder(tmp_path).secured()
