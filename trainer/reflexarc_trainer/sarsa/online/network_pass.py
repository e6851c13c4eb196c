r"""One agent through a network of one hidden layer, forwards and backwards; compiled.

With x the inputs, y the hidden units, f and g what hidden and output units compute:

    y = f(W₁ x + b₁),        Q = g(W₂ y + b₂)

and backwards from Q(s, a), with g′ and f′ the slopes at s:

    ∂Q/∂W₂[a] = g′ y,    ∂Q/∂b₂[a] = g′,    ∂Q/∂b₁ = g′ W₂[a] f′,    ∂Q/∂W₁ = ∂Q/∂b₁ xᵀ;

the rows of the other actions are 0. `weight_rows.py` says how the matrices lie in memory.
"""

from reflexarc_sim_bridge.native.decorators import fused_inline
from reflexarc_trainer.sarsa.online.row_products import affine_of_two, dot, scale
from reflexarc_trainer.sarsa.online.state import NEXT, NOW, Rules, Scratch
from reflexarc_trainer.sarsa.units import activate, times_slope


@fused_inline
def forward(rules: Rules, scratch: Scratch) -> None:
    """Fill hidden units and Q-values of s and s′ from their inputs.

    Both at once: a single pass is one long chain of dependent sums, in which the processor waits.
    """
    weights, hidden, q = scratch.weights, scratch.hidden, scratch.q_values
    x, x_next = scratch.inputs[NOW], scratch.inputs[NEXT]
    affine_of_two(weights.first, weights.first_bias, x, x_next, hidden[NOW], hidden[NEXT])
    activate(rules.units, hidden.reshape(hidden.size))
    for which in range(2):
        hidden[which, rules.hidden] = 1.0
        for h in range(rules.hidden + 1, hidden.shape[1]):
            hidden[which, h] = 0.0
    for a in range(len(weights.second)):
        q[NOW, a] = dot(weights.second[a], hidden[NOW])
        q[NEXT, a] = dot(weights.second[a], hidden[NEXT])
    activate(rules.output, q.reshape(q.size))


@fused_inline
def fill_gradient(rules: Rules, scratch: Scratch, action: int) -> None:
    """Fill `scratch.gradient` with ∇Q(s, a); `forward` must have filled the buffers."""
    into, back, slope = scratch.gradients, scratch.back, scratch.slope
    inputs, hidden = scratch.inputs[NOW], scratch.hidden[NOW]
    slope[0] = 1.0
    times_slope(rules.output, scratch.q_values[NOW, action : action + 1], slope)
    scale(slope[0], scratch.weights.second[action], back)
    times_slope(rules.units, hidden, back)
    back[rules.hidden] = 0.0
    for i in range(len(inputs)):
        scale(inputs[i], back, into.first[i])
    scale(1.0, back, into.first_bias)
    for a in range(len(into.second)):
        scale(slope[0] if a == action else 0.0, hidden, into.second[a])
