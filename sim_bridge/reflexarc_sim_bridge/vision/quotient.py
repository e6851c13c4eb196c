"""The float64 nearest to a / b by five multiplications, where 1 / b is known.

A division takes a processor many times as long as a multiplication. With y the float64
nearest to 1 / b, q = a·y is less than two units in its last place off. What a − q·b leaves takes it
to the float64 nearest to a / b or to the one beside it, and once more to the nearest (Markstein,
"Computation of elementary functions on the IBM RISC System/6000 processor", IBM J. R&D, 1990).
"""

from reflexarc_sim_bridge.native.decorators import compiled_inline
from reflexarc_sim_bridge.native.multiply_add import multiply_add


@compiled_inline
def quotient(a: float, b: float, per_b: float) -> float:
    """The float64 nearest to a / b.

    Args:
        a: finite, and not so small or large that a product with it leaves the normal numbers.
        b: the same, not 0.
        per_b: 1 / b.
    """
    near: float = a * per_b
    nearer: float = multiply_add(multiply_add(-near, b, a), per_b, near)
    nearest: float = multiply_add(multiply_add(-nearer, b, a), per_b, nearer)
    return nearest
