#!/usr/bin/env bash
# panda-gym 3.0.7: observations leave the space that is declared for them.
#
# A good guess: every observation is in `observation_space`, as the interface of Gymnasium says. The
# space is −10 to 10 for all numbers, and angular velocities of cubes that are touched are larger.
#
# Seen, with a hand that moves towards the cube (40 episodes of 30 steps; counts differ a little from
# machine to machine):
#   PandaPush-v3: 30 of 1200 observations are outside, the largest number is 44
#   PandaPickAndPlace-v3: 83 of 1200 observations are outside, the largest number is 54
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# Its simulator has wheels up to Python 3.11.
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary pybullet \
  panda-gym==3.0.7 pybullet==3.2.7 gymnasium==1.4.0 numpy==2.4.6 scipy==1.17.1
"$folder/venv/bin/python" -W ignore - <<'EOF' | grep -v -e '^argv' -e '^pybullet'
import gymnasium
import numpy as np
import panda_gym

for name, cube in [("PandaPush-v3", slice(6, 9)), ("PandaPickAndPlace-v3", slice(7, 10))]:
    env = gymnasium.make(name, disable_env_checker=True)
    rng = np.random.default_rng(1)
    outside, largest = 0, 0.0
    for seed in range(40):
        seen, _ = env.reset(seed=seed)
        for _ in range(30):
            action = rng.uniform(-1, 1, env.action_space.shape)
            towards = seen["observation"][cube] - seen["observation"][:3]
            action[:3] = np.clip(0.3 * action[:3] + 10 * towards, -1, 1)
            seen, *_ = env.step(action.astype(np.float32))
            outside += not env.observation_space.contains(seen)
            largest = max(largest, float(np.abs(seen["observation"]).max()))
    print(f"{name}: {outside} of 1200 observations are outside, the largest number is {largest:.0f}")
    assert outside > 0 and largest > 10, "panda-gym behaves differently now"
EOF
