#!/usr/bin/env bash
# Gymnasium-Robotics 1.4.2, MuJoCo 3.11.0: `render()` changes how an episode of
# FetchPickAndPlace-v4 goes on. The same seed and the same actions end millimeters apart, drawn and
# not drawn; an agent that is filmed is not the one that was measured. FetchPush-v4 is not changed.
#
# A good guess: drawing changes nothing.
#
# `mj_step` leaves the places of bodies as they were 2 ms before its end. To mark the goal, `render`
# calls `mj_forward`, which brings them up to date, and the next action is relative to where the hand
# is. FetchPush-v4 calls it in every step anyway, to hold its fingers closed. What is drawn does not
# matter: here the renderer draws nothing, so that no graphics library is needed.
#
# Seen:
#   FetchPickAndPlace-v4: again 0.0 mm, drawn 7.4 mm
#   FetchPush-v4: again 0.0 mm, drawn 0.0 mm
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
  gymnasium-robotics==1.4.2 gymnasium==1.4.0 mujoco==3.11.0 numpy==2.4.6
"$folder/venv/bin/python" -W ignore - <<'EOF'
import gymnasium
import gymnasium_robotics
import numpy as np

gymnasium.register_envs(gymnasium_robotics)


def play(name, draw):
    """Where the hand is in an episode, step by step."""
    env = gymnasium.make(name, render_mode="rgb_array")
    env.unwrapped.mujoco_renderer.render = lambda mode: np.zeros((1, 1, 3), np.uint8)
    seen = [env.reset(seed=0)[0]["observation"][:3]]
    env.action_space.seed(0)
    for _ in range(50):
        if draw:
            env.render()
        seen.append(env.step(env.action_space.sample())[0]["observation"][:3])
    return np.array(seen)


found = {}
for name in ("FetchPickAndPlace-v4", "FetchPush-v4"):
    plain = play(name, draw=False)
    again, drawn = (1000 * np.abs(play(name, draw) - plain).max() for draw in (False, True))
    print(f"{name}: again {again:.1f} mm, drawn {drawn:.1f} mm")
    found[name] = again, drawn
assert found["FetchPickAndPlace-v4"][0] == 0 and found["FetchPickAndPlace-v4"][1] > 1
assert found["FetchPush-v4"] == (0, 0)
EOF
