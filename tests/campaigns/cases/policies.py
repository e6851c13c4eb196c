"""Policies as exporters write them."""

from collections.abc import Callable
from pathlib import Path

import onnx
from onnx import TensorProto, helper, numpy_helper

from cases.case import Case, Outcome, Said, Stage, Trial

BACKENDS = ("numpy", "onnxruntime")
Change = Callable[[onnx.ModelProto], object]


def _run(stage: Stage, file: Path, backend: str) -> Said:
    """One tick of the runtime, with no body there: the policy is loaded, tried and asked."""
    words = ("run", file, "--backend", backend, "--ticks", "1", "--port", "7998")
    return stage.reflexarc(*words)


def _runs(*backends: str) -> Callable[[Stage, Path], Outcome]:
    def tried(stage: Stage, file: Path) -> Outcome:
        said = {backend: _run(stage, file, backend) for backend in backends}
        right = all(each.status == 0 and not each.has_traceback for each in said.values())
        return Outcome(right, "; ".join(f"{name} {each.status}" for name, each in said.items()))

    return tried


def _says(words: str, *backends: str) -> Callable[[Stage, Path], Outcome]:
    """Refused with status 2, in one line with these words, by every backend."""

    def tried(stage: Stage, file: Path) -> Outcome:
        said = [_run(stage, file, backend) for backend in backends]
        lines = [each.complaint.strip() for each in said]
        right = all(each.status == 2 and not each.has_traceback for each in said)
        right = right and all(words in line and "\n" not in line for line in lines)
        return Outcome(right, lines[0][-200:])

    return tried


def _given(name: str, tried: Callable[[Stage, Path], Outcome]) -> Trial:
    return lambda stage: tried(stage, stage.inputs / name)


def _made(change: Change, tried: Callable[[Stage, Path], Outcome]) -> Trial:
    """From the policy whose weights are nodes."""

    def trial(stage: Stage) -> Outcome:
        model = onnx.ModelProto.FromString((stage.inputs / "constants.onnx").read_bytes())
        change(model)
        file = stage.scratch / "made.onnx"
        file.write_bytes(model.SerializeToString())
        return tried(stage, file)

    return trial


def _external_everywhere(stage: Stage) -> Outcome:
    """The same answer from the policy's own folder and from another, by every command."""
    file, expected = stage.inputs / "external.onnx", "its weights lie in external.onnx.data; embed"
    answers = set()
    for folder in (stage.scratch, stage.inputs):
        for words in (("info", file), ("run", file, "--ticks", "1"), ("evaluate", file)):
            moved = Stage(stage.inputs, folder)
            said = moved.reflexarc(*words)
            answers.add((said.status, expected in said.complaint, said.has_traceback))
    return Outcome(answers == {(2, True, False)}, str(sorted(answers)))


def _commands_work(stage: Stage) -> Outcome:
    """The commands that load a policy work with the given one."""
    file = stage.inputs / "constants.onnx"
    tried = {
        "info": ("info", file),
        "evaluate": ("evaluate", file, "--agents", "8", "--steps", "20"),
        "run": ("run", file, "--ticks", "1", "--port", "7998"),
    }
    said = {name: stage.reflexarc(*words).status for name, words in tried.items()}
    return Outcome(set(said.values()) == {0}, str(said))


def _location(place: str) -> Change:
    def change(model: onnx.ModelProto) -> None:
        tensor = _weights(model)
        tensor.ClearField("raw_data")
        tensor.data_location = TensorProto.EXTERNAL
        tensor.external_data.add(key="location", value=place)

    return change


def _weights(model: onnx.ModelProto) -> onnx.TensorProto:
    """The largest constant."""
    tensors = [node.attribute[0].t for node in model.graph.node if node.op_type == "Constant"]
    return max(tensors, key=lambda tensor: len(tensor.raw_data))


def _opset(version: int) -> Change:
    def change(model: onnx.ModelProto) -> None:
        model.opset_import[0].version = version

    return change


def _foreign(model: onnx.ModelProto) -> None:
    node = next(node for node in model.graph.node if node.op_type == "Relu")
    node.domain = "com.example"
    model.opset_import.append(helper.make_opsetid("com.example", 1))


def _half(model: onnx.ModelProto) -> None:
    """Weights of 16 bits that are cast where they are used, as some exporters save room."""
    tensor = _weights(model)
    narrow = numpy_helper.to_array(tensor).astype("float16")
    index = next(i for i, n in enumerate(model.graph.node) if n.op_type == "Gemm")
    gemm = model.graph.node[index]
    cast = helper.make_node("Cast", [gemm.input[1]], ["widened"], to=TensorProto.FLOAT)
    tensor.CopyFrom(numpy_helper.from_array(narrow, tensor.name))
    gemm.input[1] = "widened"
    model.graph.node.insert(index, cast)


def _quantised(model: onnx.ModelProto) -> None:
    node = next(node for node in model.graph.node if node.op_type == "Relu")
    node.op_type = "DynamicQuantizeLinear"


def _no_output(model: onnx.ModelProto) -> None:
    del model.graph.output[1]


def _branch(model: onnx.ModelProto) -> None:
    node = next(node for node in model.graph.node if node.op_type == "Relu")
    node.op_type = "If"


def _empty(model: onnx.ModelProto) -> None:
    del model.graph.node[:]


def _twice(model: onnx.ModelProto) -> None:
    model.graph.node.append(model.graph.node[-1])


def _function(model: onnx.ModelProto) -> None:
    relu = helper.make_node("Relu", ["x"], ["y"])
    version = helper.make_opsetid("", 17)
    model.functions.append(helper.make_function("own", "Bend", ["x"], ["y"], [relu], [version]))
    node = next(node for node in model.graph.node if node.op_type == "Relu")
    node.op_type, node.domain = "Bend", "own"
    model.opset_import.append(helper.make_opsetid("own", 1))


def _training(model: onnx.ModelProto) -> None:
    model.training_info.add()


ELSEWHERE = "its weights lie in"
CASES: tuple[Case, ...] = (
    Case("onnx", "external.onnx", "refused from everywhere", _external_everywhere),
    Case(
        "onnx",
        "external data by an absolute path",
        "never opened",
        _made(_location("/etc/passwd"), _says(f"{ELSEWHERE} /etc/passwd; embed", *BACKENDS)),
    ),
    Case(
        "onnx",
        "external data in a folder above",
        "never opened",
        _made(_location("../secret"), _says(f"{ELSEWHERE} ../secret; embed", *BACKENDS)),
    ),
    Case("onnx", "constants.onnx", "runs on both", _given("constants.onnx", _runs(*BACKENDS))),
    Case("onnx", "constants.onnx by command", "they work", _commands_work),
    Case("onnx", "ir14.onnx on NumPy", "runs", _given("ir14.onnx", _runs("numpy"))),
    Case(
        "onnx",
        "ir14.onnx on onnxruntime",
        "the reason can be read",
        _given("ir14.onnx", _says("Unsupported model IR version: 14", "onnxruntime")),
    ),
    Case(
        "onnx",
        "initializers-as-inputs.onnx",
        "runs",
        _given("initializers-as-inputs.onnx", _runs(*BACKENDS)),
    ),
    Case(
        "onnx",
        "unsorted.onnx",
        "refused with a reason",
        _given("unsorted.onnx", _says("its nodes are not in order", *BACKENDS)),
    ),
    Case(
        "onnx",
        "an operator set too new",
        "refused with the sets that are known",
        _made(_opset(99), _says("of set 99; the NumPy backend knows sets", "numpy")),
    ),
    Case(
        "onnx",
        "an operator of another domain",
        "refused by its full name",
        _made(_foreign, _says("operator com.example.Relu", "numpy")),
    ),
    Case(
        "onnx",
        "weights of 16 bits",
        "read; but they are not those of the golden vectors",
        _made(_half, _says("golden vectors are not reproduced", "numpy")),
    ),
    Case(
        "onnx",
        "quantised",
        "refused by name",
        _made(_quantised, _says("operator DynamicQuantizeLinear", "numpy")),
    ),
    Case(
        "onnx",
        "a missing output",
        "refused by name",
        _made(_no_output, _says("got retina and q_values", *BACKENDS)),
    ),
    Case("onnx", "a branch", "refused by name", _made(_branch, _says("operator If", "numpy"))),
    Case("onnx", "no nodes", "refused", _made(_empty, _says("without a graph", *BACKENDS))),
    Case("onnx", "a value made twice", "refused", _made(_twice, _says("made twice", *BACKENDS))),
    Case(
        "onnx",
        "a function of its own",
        "runs on onnxruntime, refused by NumPy",
        _made(_function, _says("operator own.Bend", "numpy")),
    ),
    Case("onnx", "training information", "passed over", _made(_training, _runs(*BACKENDS))),
)
