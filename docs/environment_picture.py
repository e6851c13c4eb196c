"""The picture of the environments' page: `make figures`."""

import gymnasium
from PIL import Image

import reflexarc
import reflexarc.envs

policy = reflexarc.load_policy("runs/reflex-0/policy.onnx")
env = gymnasium.make("reflexarc/Crossing-v1", render_mode="rgb_array")
seen, _ = env.reset(seed=1)
for _ in range(120):
    _, actions = policy.decide(seen.reshape(1, *policy.contract.retina.stack_shape))
    seen, *_ = env.step(actions[0])
Image.fromarray(env.render()).save("docs/figures/environment.png")
