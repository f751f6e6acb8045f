#!/usr/bin/env bash
# d3rlpy 2.8.1: `d3rlpy.datasets.get_minari` pairs the actions and rewards of every episode after the
# first with observations of the wrong steps: one step too early in the second episode, two in the third.
# Those episodes begin with the end of the previous one. Nothing is said.
#
# A good guess: the observation of a step is the one in which its action was taken. An episode in
# Minari has one observation more than actions; the loader strings both together as they are, and cuts
# them at the same places.
#
# Seen, where observation, action and reward of step t in episode e are all 100 e + t:
#   episode 0: observations [0, 1, 2, 3] actions [0, 1, 2, 3] rewards [0, 1, 2, 3]
#   episode 1: observations [4, 100, 101, 102] actions [100, 101, 102, 103] rewards [100, 101, 102, 103]
#   episode 2: observations [103, 104, 200, 201] actions [200, 201, 202, 203] rewards [200, 201, 202, 203]
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
pip=("$folder/venv/bin/pip" install --quiet --disable-pip-version-check)
"${pip[@]}" 'minari[arrow]==0.5.4' gymnasium==1.4.0 numpy==2.4.6 pillow==12.0.0 pyarrow==26.0.1 \
  torch==2.15.0 h5py==3.16.0 gym==0.26.2 click==8.5.1 colorama==0.4.6 dataclasses-json==0.6.7 \
  scikit-learn==1.9.1 structlog==26.1.0 tqdm==4.70.1
# It asks for Gymnasium 1.0.0.
"${pip[@]}" --no-deps d3rlpy==2.8.1
export MINARI_DATASETS_PATH="$folder/datasets"
mkdir "$MINARI_DATASETS_PATH"
"$folder/venv/bin/python" -W ignore - <<'EOF'
import d3rlpy
import gymnasium
import minari
import numpy as np
from minari.data_collector import EpisodeBuffer


def episode(number):
    """Four steps whose observations, actions and rewards are their own numbers."""
    numbers = 100 * number + np.arange(5, dtype=np.float32)
    return EpisodeBuffer(
        observations=np.repeat(numbers[:, None], 3, axis=1),
        actions=numbers[:4, None],
        rewards=numbers[:4].tolist(),
        terminations=[False] * 4,
        truncations=[False] * 3 + [True],
    )


minari.create_dataset_from_buffers(
    "numbered-v0",
    buffer=[episode(number) for number in range(3)],
    env=gymnasium.make("Pendulum-v1"),
    observation_space=gymnasium.spaces.Box(-np.inf, np.inf, (3,)),
    action_space=gymnasium.spaces.Box(-np.inf, np.inf, (1,)),
    data_format="parquet",
)
dataset, _ = d3rlpy.datasets.get_minari("numbered-v0")
shifts = []
for number, loaded in enumerate(dataset.episodes):
    rows = [loaded.observations, loaded.actions, loaded.rewards]
    observations, actions, rewards = [values[:, 0].astype(int).tolist() for values in rows]
    print(f"episode {number}: observations {observations} actions {actions} rewards {rewards}")
    shifts.append(observations.index(actions[0]) if actions[0] in observations else None)
assert shifts == [0, 1, 2], "d3rlpy behaves differently now"
EOF
