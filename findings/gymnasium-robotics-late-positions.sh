#!/usr/bin/env bash
# Gymnasium-Robotics 1.4.2, MuJoCo 3.11.0: an observation of FetchPickAndPlace-v4 is of two moments.
# The places of hand and block, and `achieved_goal`, are those of 2 ms before the end of the step, the
# openings of the fingers those of its end. FetchPush-v4 has no such lag, so the same policy meets a
# hand that is up to 1.4 mm behind in one and not in the other.
#
# A good guess: an observation is the state after the step, as after `mj_forward`.
#
# Seen:
#   FetchPickAndPlace-v4: hand 1.36 mm behind, fingers 0.00 mm
#   FetchPush-v4: hand 0.00 mm behind, fingers 0.00 mm
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
  gymnasium-robotics==1.4.2 gymnasium==1.4.0 mujoco==3.11.0 numpy==2.4.6
"$folder/venv/bin/python" -W ignore - <<'EOF'
import gymnasium
import gymnasium_robotics
import mujoco
import numpy as np

gymnasium.register_envs(gymnasium_robotics)
found = {}
for name in ("FetchPickAndPlace-v4", "FetchPush-v4"):
    env = gymnasium.make(name).unwrapped
    env.reset(seed=0)
    hand, fingers = [], []
    for _ in range(10):
        seen = env.step(np.array([0, 1, 0.3, 1], np.float32))[0]["observation"]
        mujoco.mj_forward(env.model, env.data)
        now = env._get_obs()["observation"]
        hand.append(np.linalg.norm(now[:3] - seen[:3]))
        fingers.append(np.abs(now[9:11] - seen[9:11]).max())
    found[name] = 1000 * max(hand), 1000 * max(fingers)
    print(f"{name}: hand {found[name][0]:.2f} mm behind, fingers {found[name][1]:.2f} mm")
assert found["FetchPickAndPlace-v4"][0] > 1 and found["FetchPickAndPlace-v4"][1] == 0
assert found["FetchPush-v4"] == (0, 0)
EOF
