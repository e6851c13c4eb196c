"""What somebody else's code does wrong is told in one line that names it."""

from contextlib import AbstractContextManager

import pytest

from reflexarc_runtime.errors import PolicyError, UsageError, WorldError
from reflexarc_sim_bridge.evaluation.protocol.foreign_code import foreign_code


@pytest.mark.parametrize(
    ("context", "raised", "told"),
    [
        (foreign_code("mine"), ValueError("one\ntwo"), "mine raised ValueError: one"),
        (foreign_code(), SystemExit(3), "it raised SystemExit: 3"),
        (foreign_code("mine"), PolicyError("Q-values: no"), "mine: Q-values: no"),
        (foreign_code(), PolicyError("Q-values: no"), "Q-values: no"),
    ],
)
def test_it_names_whom_it_is_about(
    context: AbstractContextManager[None], raised: BaseException, told: str
) -> None:
    with pytest.raises(UsageError) as caught, context:
        raise raised
    assert str(caught.value) == told


def test_what_the_house_itself_refuses_stays_what_it_is() -> None:
    with pytest.raises(WorldError, match=r"^world: no$"), foreign_code("mine"):
        raise WorldError("world: no")
