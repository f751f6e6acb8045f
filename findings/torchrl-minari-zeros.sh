#!/usr/bin/env bash
# TorchRL 0.14.1: `MinariExperienceReplay` returns zeros for every observation, action and reward, and no
# episode ends, whatever the Minari dataset holds; so a policy learns from nothing. Nothing is said.
# Its source is the same in this place since 0.11.1 at the latest.
#
# A good guess: the replay buffer holds the dataset. It copies the dataset to memory first, and then
# stores what `TensorDict.memmap_like` returns, which has the shapes and not the values.
#
# Seen, for two episodes with the numbers from 1 to 5 and from 11 to 15:
#   Minari: observations [1, 2, 3, 4, 5, 11, 12, 13, 14, 15] rewards [1, 2, 3, 4, 5, 11, 12, 13, 14, 15] ends 2
#   TorchRL: observations [0, 0, 0, 0, 0, 0, 0, 0, 0, 0] rewards [0, 0, 0, 0, 0, 0, 0, 0, 0, 0] ends 0
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
  minari==0.5.4 gymnasium==1.4.0 numpy==2.4.6 pillow==12.0.0 h5py==3.16.0 \
  torch==2.15.0 torchrl==0.14.1 tensordict==0.14.3
export MINARI_DATASETS_PATH="$folder/datasets" RL_LOGGING_LEVEL=ERROR
mkdir "$MINARI_DATASETS_PATH"
"$folder/venv/bin/python" -W ignore - <<'EOF'
import os

import gymnasium
import minari
import numpy as np
from minari.data_collector import EpisodeBuffer
from torchrl.data.datasets import MinariExperienceReplay


def episode(first):
    """Five steps whose observations and rewards are their numbers, and which is cut off."""
    numbers = first + np.arange(6, dtype=np.float32)
    return EpisodeBuffer(
        observations=np.repeat(numbers[:, None], 4, axis=1),
        actions=np.ones(5, np.int64),
        rewards=numbers[:5].tolist(),
        terminations=[False] * 5,
        truncations=[False] * 4 + [True],
    )


def show(reader, observations, rewards, ends):
    observations, rewards = [np.asarray(x).astype(int).tolist() for x in (observations, rewards)]
    print(f"{reader}: observations {observations} rewards {rewards} ends {int(ends.sum())}")


dataset = minari.create_dataset_from_buffers(
    "numbered-v0",
    buffer=[episode(1), episode(11)],
    env=gymnasium.make("CartPole-v1"),
    observation_space=gymnasium.spaces.Box(-np.inf, np.inf, (4,)),
    data_format="hdf5",
)
episodes = list(dataset.iterate_episodes())
show(
    "Minari",
    np.concatenate([episode.observations[:-1, 0] for episode in episodes]),
    np.concatenate([episode.rewards for episode in episodes]),
    np.concatenate([episode.truncations for episode in episodes]),
)
replay = MinariExperienceReplay(
    "numbered-v0",
    batch_size=5,
    root=os.path.join(os.environ["MINARI_DATASETS_PATH"], "torchrl"),
    load_from_local_minari=True,
)
rows = replay[:]
show("TorchRL", rows["observation"][:, 0], rows["next", "reward"][:, 0], rows["next", "truncated"])
assert not rows["observation"].any(), "TorchRL behaves differently now"
EOF
