import pytest
from hypothesis import given
from hypothesis import strategies as st

import reflexarc_logs
from reflexarc_logs.container.run_info import RunInfo, installed_versions
from reflexarc_runtime.errors import LogError

texts = st.text(max_size=20)
infos = st.builds(
    RunInfo,
    run_id=texts,
    robot=texts,
    input=st.sampled_from(["retina", "scan"]),
    backend=st.sampled_from(["numpy", "onnxruntime"]),
    rate_hz=st.floats(allow_nan=False),
    clock=st.sampled_from(["monotonic", "lockstep"]),
    recorded_by=st.sampled_from(["run", "record"]),
    policy_seed=st.integers(),
    commit=texts,
    host=texts,
    versions=st.dictionaries(texts, texts, max_size=3),
    policy_hash=texts,
    wall_offset_ns=st.integers(0, 2**63),
)


@given(info=infos)
def test_a_run_survives_its_metadata_one_string_a_field(info):
    document = info.to_metadata()
    assert all(isinstance(value, str) for value in document.values())
    assert RunInfo.from_metadata(document) == info


def test_a_field_that_is_missing_has_its_default():
    assert RunInfo.from_metadata({"run_id": "ab"}) == RunInfo("ab")


def test_a_run_without_an_identity_is_refused():
    with pytest.raises(LogError, match="expected a run_id"):
        RunInfo.from_metadata({"robot": "robot0"})


@pytest.mark.parametrize(
    ("field", "text", "words"),
    [
        ("rate_hz", "fast", "reflexarc.run.rate_hz: got 'fast'; the log is damaged"),
        ("seed", "1.5", "reflexarc.run.policy_seed: got '1.5'; the log is damaged"),
        ("versions", "{", "reflexarc.run.versions: got '{'; the log is damaged"),
        ("versions", "[]", r"reflexarc.run.versions: expected an object, got \[\]"),
        ("clock", "sun", "reflexarc.run.clock: expected monotonic or lockstep, got 'sun'"),
    ],
)
def test_a_damaged_field_is_refused_by_its_name(field, text, words):
    with pytest.raises(LogError, match=words):
        RunInfo.from_metadata({"run_id": "ab", field: text})


def test_a_field_of_a_newer_version_is_left_alone():
    assert RunInfo.from_metadata({"run_id": "ab", "weather": "fine"}) == RunInfo("ab")


def test_the_versions_name_python_and_what_computes():
    versions = installed_versions()
    assert versions["python"].startswith("3.")
    assert {"numpy", "onnx", "mcap", "protobuf"} <= versions.keys()


def test_every_public_name_is_there_and_no_other():
    for name in reflexarc_logs.__all__:
        assert getattr(reflexarc_logs, name).__name__ == name
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = reflexarc_logs.nonsense
