#!/usr/bin/env bash
# TorchRL 0.14.1: `MinariExperienceReplay` cannot load a Minari dataset of one episode: it ends in a
# TypeError that names neither the dataset nor its length. With two episodes it loads.
#
# A good guess: a dataset of one episode loads as one of two does. The line that reports the number of
# episodes unpacks their numbers for `max`, which takes a single one for a list.
#
# Seen:
#   episodes: 1 TypeError: 'int' object is not iterable
#   episodes: 2 transitions: 10
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


def episode():
    """An episode of CartPole's spaces that is cut off after five steps."""
    return EpisodeBuffer(
        observations=np.zeros((6, 4), np.float32),
        actions=np.zeros(5, np.int64),
        rewards=[1.0] * 5,
        terminations=[False] * 5,
        truncations=[False] * 4 + [True],
    )


def load(episodes):
    name = f"episodes-{episodes}-v0"
    minari.create_dataset_from_buffers(
        name,
        buffer=[episode() for _ in range(episodes)],
        env=gymnasium.make("CartPole-v1"),
        data_format="hdf5",
    )
    folder = os.path.join(os.environ["MINARI_DATASETS_PATH"], "torchrl")
    return MinariExperienceReplay(
        name, batch_size=5, root=folder, load_from_local_minari=True
    )


try:
    load(1)
    raise SystemExit("TorchRL behaves differently now")
except TypeError as error:
    print("episodes: 1 TypeError:", error)
print("episodes: 2 transitions:", len(load(2)))
EOF
