"""A baseline as a policy file, which a robot runs and a log replays.

Its `decide` is run once on stand-ins (`graph_tensor.py`), which write down its graph; the file is
then held to what `decide` computes, on retinas and memories of all kinds, on both backends.
"""

import dataclasses
import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from reflexarc_baselines.baseline import Baseline, Remembering
from reflexarc_baselines.exporting.array_rules import FUNCTIONS, for_every_agent
from reflexarc_baselines.exporting.element_rules import UFUNCS
from reflexarc_baselines.exporting.graph_tensor import GraphScribe
from reflexarc_runtime.arrays import Memories, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.provenance import Provenance
from reflexarc_runtime.errors import PolicyError
from reflexarc_trainer.policy.graph_export import export_graph, finished
from reflexarc_trainer.policy.parity import Decided, Original
from reflexarc_trainer.policy.probes import probe_retinas
from reflexarc_trainer.policy.provenance import commit, versions
from reflexarc_trainer.policy.translation.graph_builder import Translation


def export_baseline(
    baseline: Baseline | Remembering,
    name: str,
    path: Path,
    *,
    rate_hz: float | None = None,
    recorded: RetinaBatch | None = None,
) -> PolicyContract:
    """Write a baseline as a policy file.

    Args:
        baseline: what decides.
        name: what the file says it is.
        path: the file.
        rate_hz: decisions a second; the contract's own if None. A baseline that counts its
            decisions as time is told so.
        recorded: retinas of a drive, to check beside random ones.

    Returns:
        The contract as written.

    Raises:
        ContractError: that is no rate.
        PolicyError: it computes what no graph can, or the file would decide otherwise. Nothing is
            written.
    """
    rate_hz = baseline.contract.rate_hz if rate_hz is None else rate_hz
    baseline, contract = _at_rate(baseline, rate_hz)
    contract = dataclasses.replace(contract, provenance=_provenance(baseline, name))
    try:
        graph, q_values, following = _written(baseline, contract)
        model = finished(graph, q_values, following, contract)
        original = Original("decide", lambda r, m: _decided(baseline, r, m), is_double=False)
        retinas = probe_retinas(contract, recorded)
        return export_graph(model, original, contract, path, retinas)
    except PolicyError as error:
        raise PolicyError(f"baseline {name}: {error}") from None
    except TypeError as error:  # an argument that no rule knows
        raise PolicyError(f"baseline {name}: it cannot be written as a graph: {error}") from error


def _at_rate(
    baseline: Baseline | Remembering, rate_hz: float
) -> tuple[Baseline | Remembering, PolicyContract]:
    dataclasses.replace(baseline.contract, rate_hz=rate_hz)  # refuses what is no rate
    if "period_s" in {field.name for field in dataclasses.fields(baseline)}:  # type: ignore[arg-type]  # a protocol of dataclasses
        baseline = dataclasses.replace(baseline, period_s=1.0 / rate_hz)  # type: ignore[type-var]  # the same
    return baseline, dataclasses.replace(baseline.contract, rate_hz=rate_hz)


def _written(baseline: Any, contract: PolicyContract) -> tuple[Translation, str, str | None]:
    """The graph, and the names of the Q-values and the next memories in it."""
    scribe = GraphScribe(Translation(), UFUNCS, FUNCTIONS)
    retina = scribe.tensor("retina", np.zeros((1, *contract.retina.stack_shape), np.uint8))
    if not contract.state.size:
        q_values, _ = baseline.decide(retina)
        return scribe.graph, _floats(scribe, q_values), None
    start = np.array([contract.state.start_value], np.float32)
    q_values, _, following = baseline.decide(retina, scribe.tensor("state", start))
    return scribe.graph, _floats(scribe, q_values), _floats(scribe, following)


def _floats(scribe: GraphScribe, value: Any) -> str:
    """The name of a result as float32, one row an agent."""
    return for_every_agent(scribe, value, np.float32).name


def _decided(baseline: Any, retinas: RetinaBatch, memories: Memories | None) -> Decided:
    if memories is None:
        q_values, actions = baseline.decide(retinas)
        return q_values, actions, None
    decided: Decided = baseline.decide(retinas, memories)
    return decided


def _provenance(baseline: Any, name: str) -> Provenance:
    """Its name, its parameters, and what it was exported with."""
    config = {"baseline": name, "class": type(baseline).__name__, "parameters": repr(baseline)}
    digest = hashlib.sha256(json.dumps(config, sort_keys=True).encode()).hexdigest()
    return Provenance(
        preset=f"baseline {name}",
        config=config,
        config_hash=digest,
        versions=versions(),
        commit=commit(),
    )
