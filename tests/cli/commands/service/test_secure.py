import json
import stat
from pathlib import Path

import pytest

pytest.importorskip("cryptography")

from reflexarc.main import main
from reflexarc.securing.policy_keys import make_key
from reflexarc_runtime.contract.contract import PolicyContract
from support.policies import exported


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--host", "10.0.0.1:7447"], "--host"),
        (["--host", "0.0.0.0"], "no address that another machine can reach"),
        (["--host", "a b"], "--host"),
        (["--host", "tls/10.0.0.1"], "--host"),
        (["--host", ""], "--host"),
        (["--host", "rover..local"], "--host"),
        (["--host", ".local"], "--host"),
        (["--host", "rover.local."], "--host"),
        (["--host", "rover-.local"], "--host"),
        (["--host", "*.local"], "--host"),
        (["--host", "10.0.0.300"], "--host"),
        (["--host", "x" * 64 + ".local"], "--host"),
        (["--host", "straße.example"], "--host"),
        (["--robot", "a/b"], "--robot"),
        (["--robot", "x" * 60], "--robot"),
        (["--port", "0"], "--port"),
        (["--days", "0"], "--days"),
        (["--days", "1e9"], "--days"),
    ],
)
def test_what_cannot_be_is_refused_and_nothing_is_made(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    assert main(["secure", "init", str(tmp_path / "keys"), *words]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert said in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "host", ["rover1.local", "rover", "a-b.c_d.example", "10.0.0.1", "fd00::1"]
)
def test_names_and_addresses_of_hosts_are_taken(host: str, tmp_path: Path):
    assert main(["secure", "init", str(tmp_path / "keys"), "--host", host]) == 0


def test_init_says_what_to_copy_where(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    folder = tmp_path / "keys"
    assert main(["secure", "init", str(folder), "--host", "10.0.0.1", "--robot", "r7"]) == 0
    said = capsys.readouterr().out
    for role in ("body", "runtime", "recorder", "operator", "viewer"):
        assert f"{folder}/{role}.json5: reflexarc " in said
        assert f"--zenoh {role}.json5 --robot r7" in said
    assert main(["secure", "init", str(folder)]) == 2
    assert "nothing is overwritten" in capsys.readouterr().err


def test_a_key_is_made_and_signs(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    policy, key = tmp_path / "policy.onnx", tmp_path / "mine.key"
    policy.write_bytes(exported(PolicyContract(), seed=5))
    assert main(["secure", "sign", str(policy)]) == 2
    assert "--key" in capsys.readouterr().err
    assert main(["secure", "key", str(key), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["public"] == str(tmp_path / "mine.pub")
    assert stat.S_IMODE(key.stat().st_mode) == 0o600
    assert main(["secure", "sign", str(policy), "--key", str(key)]) == 0
    assert (tmp_path / "policy.onnx.sig").stat().st_size == 64


@pytest.mark.parametrize(
    "words",
    [
        ["secure", "key", "."],
        ["secure", "key", "/"],
        ["secure", "key", ".."],
        ["secure", "sign", ".", "--key", "mine.key"],
        ["secure", "sign", "/dev/zero", "--key", "mine.key"],
        ["secure", "sign", "policy.onnx", "--key", "/dev/zero"],
        ["secure", "sign", "policy.onnx", "--key", "."],
        ["swap", "."],
        ["run", ".", "--require-signature", "mine.pub"],
    ],
    ids=" ".join,
)
def test_what_is_no_file_is_refused_in_one_line(
    words: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
):
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    (folder / "policy.onnx").write_bytes(b"any")
    make_key(folder / "mine.key")
    before = sorted(tmp_path.rglob("*"))
    assert main(words) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize("policy", [b"no policy at all", b""])
def test_run_parses_nothing_of_a_policy_that_nobody_vouched_for(
    policy: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    """These files cannot be parsed: it would be said, were it tried."""
    file = tmp_path / "policy.onnx"
    file.write_bytes(policy)
    assert main(["secure", "key", str(tmp_path / "mine.key")]) == 0
    asked: list[tuple[list[str], str]] = [
        (["--expect-hash", "ab" * 32], "--expect-hash"),
        (["--require-signature", str(tmp_path / "mine.pub")], "policy.onnx.sig"),
        (["--expect-hash", "ab"], "64 digits"),
        (["--expect-hash", ""], "64 digits"),
        (["--require-signature", "/dev/null"], "not a public key: the file is empty"),
        (["--require-signature", str(tmp_path / "none.pub")], "none.pub"),
    ]
    capsys.readouterr()
    for words, said in asked:
        assert main(["run", str(file), "--ticks", "1", *words]) == 2
        [line] = capsys.readouterr().err.splitlines()
        assert said in line


def test_run_refuses_a_bus_that_lets_in_strangers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    file, policy = tmp_path / "zenoh.json5", tmp_path / "policy.onnx"
    policy.write_bytes(exported(PolicyContract(), seed=5))
    tls = "transport: { link: { tls: { root_ca_certificate: 'ca.pem', enable_mtls: true } } }"
    file.write_text(f"{{ {tls} }}")  # the obvious file: it says nothing of listeners
    for words in (
        ["run", str(policy), "--no-guard", "--ticks", "1"],
        ["sim", "--policy", str(policy)],
        ["record", "-o", str(tmp_path / "log.mcap")],
        ["play", "tests/golden/nominal.mcap"],
        ["stop"],
    ):
        assert main([*words, "--zenoh", str(file)]) == 2
        *_, line = capsys.readouterr().err.splitlines()
        assert "tcp/[::]:0, which lets in whoever reaches it" in line
        assert "multicast" in line
        assert "--allow-open" in line
