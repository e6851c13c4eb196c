import dataclasses
import json
import threading
from pathlib import Path

import numpy as np
import onnx
import pytest
from onnx import helper, numpy_helper
from onnx.reference import ReferenceEvaluator

from reflexarc_runtime.contract.contract import METADATA_KEY, PolicyContract
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import (
    ContractError,
    DecisionEndedError,
    PolicyError,
    ReflexarcError,
)
from reflexarc_runtime.policy import model_file
from reflexarc_runtime.policy.agreement import flips, within_tolerance
from reflexarc_runtime.policy.model_file import policy_hash, with_contract
from reflexarc_runtime.policy.numpy_backend import supported_operators
from reflexarc_runtime.policy.policy import load_contract, load_policy
from support.looping_policies import FOR_EVER, looping
from support.policies import SMALL, exported, network

RETINAS = np.random.default_rng(3).integers(
    0, 256, (500, *SMALL.retina.stack_shape), dtype=np.uint8
)


class SilentError(Exception):
    """An error without a message."""


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (SilentError(), "SilentError"),
        (SilentError(" \n "), "SilentError"),
        (SilentError("\nfirst\nsecond"), "first"),
        (SilentError("x" * 999), "x" * 200),
    ],
)
def test_an_onnxruntime_that_refuses_is_quoted_in_one_line(
    monkeypatch: pytest.MonkeyPatch, error: Exception, said: str
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("onnxruntime.InferenceSession", refuse)
    with pytest.raises(PolicyError) as caught:
        load_policy(exported(SMALL), "onnxruntime")
    assert str(caught.value) == f"policy: onnxruntime refuses the model: {said}"


def changed(data: bytes, edit: object) -> bytes:
    model = onnx.ModelProto.FromString(data)
    edit(model)  # type: ignore[operator]
    return model.SerializeToString()


@pytest.mark.parametrize("activation", ["Sigmoid", "Relu", "Tanh", "Softplus"])
def test_numpy_agrees_with_the_reference_evaluator_of_onnx(activation: str):
    data = exported(SMALL, activation=activation) if activation != "Softplus" else None
    model = network(SMALL, activation=activation)
    policy = load_policy(data or with_contract(model, SMALL), verify=False)
    q_values, actions = policy.decide(RETINAS)
    oracle_q, oracle_actions = ReferenceEvaluator(model).run(None, {"retina": RETINAS})
    assert within_tolerance(oracle_q, q_values)
    assert not flips(oracle_actions, actions, q_values).any()


def test_numpy_rounds_the_exact_value_once():
    """Against the same network in extended precision, rounded once to float32."""
    policy = load_policy(exported(SMALL))
    weights = {
        t.name: numpy_helper.to_array(t).astype(np.longdouble)
        for t in onnx.ModelProto.FromString(policy.data).graph.initializer
    }
    inputs = RETINAS.reshape(len(RETINAS), -1).astype(np.longdouble) / weights["scale"]
    hidden = 1 / (1 + np.exp(-(inputs @ weights["w1"].T + weights["b1"])))
    exact = (hidden @ weights["w2"].T + weights["b2"]).astype(np.float32)
    assert policy.decide(RETINAS)[0].tobytes() == exact.tobytes()


def test_one_at_a_time_gives_the_bits_of_the_batch():
    policy = load_policy(exported(SMALL))
    batch, _ = policy.decide(RETINAS)
    single = np.concatenate([policy.decide(retina[np.newaxis])[0] for retina in RETINAS])
    assert single.tobytes() == batch.tobytes()


def test_both_backends_agree_in_the_action_and_to_the_tolerance():
    data = exported(SMALL)
    numpy_q, numpy_actions = load_policy(data, "numpy").decide(RETINAS)
    ort_q, ort_actions = load_policy(data, "onnxruntime").decide(RETINAS)
    assert within_tolerance(ort_q, numpy_q)
    assert not flips(ort_actions, numpy_actions, numpy_q).any()


def test_a_tie_takes_the_first_action():
    def no_weights(model: onnx.ModelProto) -> None:
        for tensor in model.graph.initializer:
            if tensor.name != "scale":
                zeros = np.zeros_like(numpy_helper.to_array(tensor))
                tensor.CopyFrom(numpy_helper.from_array(zeros, tensor.name))

    data = with_contract(changed(network(SMALL), no_weights), SMALL)
    for backend in ("numpy", "onnxruntime"):
        assert load_policy(data, backend, verify=False).decide(RETINAS)[1].tolist() == [0] * 500


def test_the_hash_is_that_of_the_file(tmp_path: Path):
    path = tmp_path / "policy.onnx"
    path.write_bytes(exported(SMALL))
    assert load_policy(path).policy_hash == policy_hash(path.read_bytes())


def test_a_difference_beyond_the_tolerance_is_a_flip_and_one_below_is_rounding():
    reference = np.array([[0.5, 0.4, 0.0], [0.5, 0.5 - 1e-7, 0.0]], np.float32)
    assert flips(np.array([1, 1]), np.array([0, 0]), reference).tolist() == [True, False]


def negate_a_live_weight(model: onnx.ModelProto) -> None:
    tensor = next(t for t in model.graph.initializer if t.name == "w2")
    weights = numpy_helper.to_array(tensor).copy()
    weights[0, 0] = -weights[0, 0]
    tensor.CopyFrom(numpy_helper.from_array(weights, "w2"))


def rename_output(model: onnx.ModelProto) -> None:
    model.graph.output[0].name = "values"


def use_unknown_operator(model: onnx.ModelProto) -> None:
    model.graph.node[4].op_type = "Shrink"


def take_the_last_of_a_tie(model: onnx.ModelProto) -> None:
    model.graph.node[-1].attribute.append(helper.make_attribute("select_last_index", 1))


def drop_vectors(model: onnx.ModelProto) -> None:
    model.CopyFrom(onnx.ModelProto.FromString(with_contract(network(SMALL), SMALL)))


def newer_schema(model: onnx.ModelProto) -> None:
    for entry in model.metadata_props:
        if entry.key == METADATA_KEY:
            entry.value = json.dumps({**json.loads(entry.value), "schema": 99})


def another_eye(model: onnx.ModelProto) -> None:
    bigger = dataclasses.replace(SMALL, retina=dataclasses.replace(SMALL.retina, rays=9))
    other = load_policy(exported(bigger)).contract
    model.CopyFrom(onnx.ModelProto.FromString(with_contract(exported(SMALL), other)))


def weights_of(model: onnx.ModelProto) -> onnx.TensorProto:
    return next(t for t in model.graph.initializer if t.name == "w2")


def cut_weights(model: onnx.ModelProto) -> None:
    weights_of(model).raw_data = weights_of(model).raw_data[:-3]


def unknown_type(model: onnx.ModelProto) -> None:
    weights_of(model).data_type = 99


def weights_elsewhere(model: onnx.ModelProto) -> None:
    weights_of(model).ClearField("raw_data")
    weights_of(model).data_location = onnx.TensorProto.EXTERNAL


def no_output(model: onnx.ModelProto) -> None:
    model.graph.node[0].ClearField("output")


def contract_edit(model: onnx.ModelProto, change: dict[str, object]) -> None:
    for entry in model.metadata_props:
        if entry.key == METADATA_KEY:
            entry.value = json.dumps({**json.loads(entry.value), **change})


def golden_action_out_of_range(model: onnx.ModelProto) -> None:
    golden = dataclasses.asdict(load_policy(exported(SMALL)).contract.golden)
    contract_edit(model, {"golden": {**golden, "actions": [99] * len(golden["actions"])}})


def endless_rate(model: onnx.ModelProto) -> None:
    contract_edit(model, {"rate_hz": 10**400})


@pytest.mark.parametrize("backend", ["numpy", "onnxruntime"])
@pytest.mark.parametrize(
    "edit",
    [
        cut_weights,
        unknown_type,
        weights_elsewhere,
        no_output,
        golden_action_out_of_range,
        endless_rate,
    ],
)
def test_a_damaged_policy_is_refused_in_one_line(edit: object, backend: str):
    with pytest.raises(ReflexarcError) as caught:
        load_policy(changed(exported(SMALL), edit), backend)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (negate_a_live_weight, "golden vectors are not reproduced"),
        (rename_output, "no node makes its output 'values'"),
        (use_unknown_operator, "operator Shrink"),
        (take_the_last_of_a_tie, "select_last_index"),
        (drop_vectors, "no golden vectors"),
        (newer_schema, "newer than this reflexarc"),
        (another_eye, "expected a retina (n, 1, 1, 9, 1)"),
    ],
)
def test_a_policy_that_is_not_what_it_says_is_refused(edit: object, words: str):
    with pytest.raises(ReflexarcError) as caught:
        load_policy(changed(exported(SMALL), edit))
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_unknown_operator_runs_on_onnxruntime_and_the_refusal_says_so():
    with pytest.raises(PolicyError, match="--backend onnxruntime"):
        load_policy(exported(SMALL, activation="Shrink"))
    policy = load_policy(exported(SMALL, activation="Shrink"), "onnxruntime")
    assert policy.decide(RETINAS)[0].shape == (500, 3)
    assert "Shrink" not in supported_operators()


@pytest.mark.parametrize("backend", ["numpy", "onnxruntime"])
@pytest.mark.parametrize("data", [b"", b"not a model", bytes(1000), exported(SMALL)[:200]])
def test_bytes_that_are_no_policy_are_refused(data: bytes, backend: str):
    with pytest.raises(ReflexarcError) as caught:
        load_policy(data, backend)
    assert "\n" not in str(caught.value)


def test_a_model_without_a_contract_is_refused():
    with pytest.raises(ContractError, match="found none"):
        load_policy(network(SMALL))


def test_a_body_reads_the_contract_of_a_graph_that_it_could_not_compute():
    hangs = looping(PolicyContract(), FOR_EVER)
    assert load_contract(hangs).actions == PolicyContract().actions
    with pytest.raises(PolicyError, match="NumPy backend"):
        load_policy(hangs)


def test_a_contract_is_refused_as_its_policy_would_be(monkeypatch: pytest.MonkeyPatch):
    fast = exported(PolicyContract(actions=(Action("fast", 1000.0, 0.0), Action("b", 0.0, 0.0))))
    with pytest.raises(ContractError, match="--max-speed-mps"):
        load_contract(fast)
    assert load_contract(fast, bounds=None).actions[0].linear_mps == 1000.0
    with pytest.raises(PolicyError, match="expected an ONNX model"):
        load_contract(b"not a model")
    monkeypatch.setattr(model_file, "MAX_FILE_BYTES", 100)
    with pytest.raises(PolicyError, match="at most 64 MiB"):
        load_contract(exported(SMALL))


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path):
    for path in (tmp_path / "none.onnx", tmp_path):
        with pytest.raises(PolicyError, match=str(path)):
            load_policy(path)


def test_every_byte_of_a_policy_may_be_broken_without_a_traceback():
    """A file that is changed anywhere loads, or is refused as an input's fault: nothing else."""
    data = exported(PolicyContract(retina=SMALL.retina))
    for position in range(0, len(data), 61):
        broken = bytearray(data)
        broken[position] ^= 0x55
        try:
            load_policy(bytes(broken))
        except ReflexarcError as error:
            assert "\n" not in str(error)  # noqa: PT017


def test_a_run_of_onnxruntime_is_ended_from_another_thread_and_the_next_one_goes_on():
    policy = load_policy(looping(SMALL, FOR_EVER, at_intensity=200), "onnxruntime")
    ended = threading.Event()

    def end() -> None:
        while not ended.wait(0.01):
            policy.end_decision()

    ending = threading.Thread(target=end)
    ending.start()
    with pytest.raises(DecisionEndedError):
        policy.decide(np.full((1, *SMALL.retina.stack_shape), 200, np.uint8))
    ended.set()
    ending.join()
    assert policy.decide(np.zeros((1, *SMALL.retina.stack_shape), np.uint8))[1].tolist() == [1]


def test_a_contract_is_read_without_building_a_graph_that_only_onnxruntime_can_compute():
    contract = PolicyContract()
    data = looping(contract, FOR_EVER)
    with pytest.raises(PolicyError, match="not in the NumPy backend"):
        load_policy(data, verify=False)
    assert load_contract(data).actions == contract.actions


def test_a_contract_that_asks_for_too_much_is_refused_without_its_graph_too():
    fast = dataclasses.replace(SMALL, actions=(Action("a", 1e300, 0.0), Action("b", 0.0, 0.0)))
    with pytest.raises(ContractError, match="a"):
        load_contract(with_contract(network(fast), fast))
    with pytest.raises(PolicyError, match="ONNX"):
        load_contract(b"no model")
