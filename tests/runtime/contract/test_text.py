"""The sealed text of a contract: no accident to it goes unseen."""

import json
from dataclasses import replace
from typing import Any

import onnx
import pytest

from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.contract.contract import METADATA_KEY, PolicyContract, why_unsealed
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.contract.text import digest_of, seal
from reflexarc_runtime.errors import ContractError, ReflexarcError
from reflexarc_runtime.policy.policy import load_policy
from support.policies import SMALL, exported

FULL = PolicyContract(
    retina=RetinaSpec(rays=4),
    body=BodySpec(Footprint(radius_m=0.2), 0.05, 1.5),
    hold_s=0.1,
    margin=0.25,
    least_lead=0.08,
    q_tolerance=2e-6,
    recovery_inputs=5,
    state=StateSpec(2, (0.5, -1.0)),
)


def sealed(document: dict[str, Any]) -> str:
    """A text of any schema with the digest that fits it, as `seal` makes it of today's."""
    body = json.dumps(document, sort_keys=True, separators=(",", ":"))
    return f'{{"digest":"{digest_of(body)}",{body[1:]}'


def test_every_field_survives():
    assert PolicyContract.from_json(FULL.to_json()) == FULL


def test_every_single_flipped_bit_of_the_text_is_refused():
    """All of them: in keys, numbers, braces, the schema's number and the digest itself."""
    data = FULL.to_json().encode()
    for bit in range(8 * len(data)):
        flipped = bytearray(data)
        flipped[bit // 8] ^= 1 << bit % 8
        try:
            text = flipped.decode()
        except UnicodeDecodeError:
            continue  # no text at all: see the next test
        with pytest.raises(ContractError):
            PolicyContract.from_json(text)


def test_every_seventh_flipped_bit_of_the_text_in_its_file_is_refused_in_one_line():
    data = exported(SMALL)
    begin = data.index(b'{"digest"')
    for bit in range(0, 8 * len(SMALL.to_json()), 7):
        flipped = bytearray(data)
        flipped[begin + bit // 8] ^= 1 << bit % 8
        with pytest.raises(ReflexarcError) as caught:
            load_policy(bytes(flipped))
        assert "\n" not in str(caught.value)


def test_a_flipped_bit_in_the_key_leaves_no_contract():
    data = exported(SMALL)
    with pytest.raises(ContractError, match="found none"):
        load_policy(data.replace(METADATA_KEY.encode(), b"reflexarc.contrabt"))


def test_a_text_that_was_edited_and_not_sealed_is_refused():
    edited = FULL.to_json().replace('"margin":0.25', '"margin":0.20')
    with pytest.raises(ContractError, match="its digest"):
        PolicyContract.from_json(edited)
    document = json.loads(FULL.to_json())
    with pytest.raises(ContractError, match="expected a digest"):
        PolicyContract.from_json(json.dumps({**document, "margin": 0.2}))


def test_a_text_of_today_cannot_pass_for_an_older_one():
    document = json.loads(FULL.to_json())
    del document["digest"]
    for schema in (1, 2):
        with pytest.raises(ContractError, match="unknown in a text of that schema"):
            PolicyContract.from_json(json.dumps({**document, "schema": schema}))
    with pytest.raises(ContractError, match="least_lead: unknown in a text of that schema"):
        PolicyContract.from_json(sealed({**document, "schema": 3}))


def test_an_old_text_loads_with_a_note_and_means_what_it_meant():
    document = json.loads(replace(FULL, state=StateSpec()).to_json())
    later = ("body", "goal", "hold_s", "least_lead", "margin", "q_tolerance", "recovery_inputs")
    for name in ("digest", *later):
        del document[name]
    del document["state"], document["retina"]["beams"], document["golden"]["sequences"]
    old = json.dumps({**document, "schema": 2})
    one_beam = replace(FULL.retina, beams=BeamRule.NEAREST_BEAM)
    assert PolicyContract.from_json(old) == PolicyContract(retina=one_beam)
    assert "schema 2, which has no digest" in why_unsealed(old)
    assert why_unsealed(FULL.to_json()) == ""


def test_a_sealed_text_of_schema_3_has_no_least_lead_and_means_none():
    document = json.loads(FULL.to_json())
    del document["digest"], document["least_lead"]
    old = sealed({**document, "schema": 3})
    assert PolicyContract.from_json(old) == replace(FULL, least_lead=0.0)
    assert why_unsealed(old) == ""


def test_a_contract_in_a_file_is_still_an_onnx_property_that_any_tool_reads():
    model = onnx.ModelProto.FromString(exported(SMALL))
    (text,) = (p.value for p in model.metadata_props if p.key == METADATA_KEY)
    assert json.loads(text)["schema"] == 4
    assert len(json.loads(text)["digest"]) == 64


def test_sealing_is_canonical():
    document = {"b": 1, "a": [0.1]}
    assert seal(document) == seal(dict(reversed(document.items())))
