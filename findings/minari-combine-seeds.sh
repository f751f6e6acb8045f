#!/usr/bin/env bash
# Minari 0.5.4: `combine_datasets` (and `minari combine`) of datasets in Parquet or Arrow storage loses
# the seeds of all episodes, so that no episode of the combined dataset can be played again. Nothing is
# said.
#
# A good guess: the metadata of each episode are in the combined dataset, too.
#
# Seen:
#   parquet [10, 11] and [20, 21] make [None, None, None, None]
#   arrow [10, 11] and [20, 21] make [None, None, None, None]
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
  'minari[arrow]==0.5.4' gymnasium==1.4.0 numpy==2.4.6 pillow==12.0.0 pyarrow==26.0.1
export MINARI_DATASETS_PATH="$folder/datasets"
mkdir "$MINARI_DATASETS_PATH"
"$folder/venv/bin/python" -W ignore - <<'EOF'
import gymnasium
import minari
import numpy as np
from minari.data_collector import EpisodeBuffer


def episode(steps, seed, **more):
    """An episode of CartPole's spaces that is cut off after so many steps."""
    return EpisodeBuffer(
        seed=seed,
        observations=np.zeros((steps + 1, 4), np.float32),
        actions=np.zeros(steps, np.int64),
        rewards=[1.0] * steps,
        terminations=[False] * steps,
        truncations=[False] * (steps - 1) + [True],
        **more,
    )


def create(name, episodes, data_format):
    env = gymnasium.make("CartPole-v1")
    return minari.create_dataset_from_buffers(
        name, buffer=episodes, env=env, data_format=data_format
    )


def seeds(dataset):
    numbers = range(dataset.total_episodes)
    return [metadata.get("seed") for metadata in dataset.storage.get_episode_metadata(numbers)]


for data_format in ["parquet", "arrow"]:
    first = create(f"{data_format}-first-v0", [episode(5, 10), episode(6, 11)], data_format)
    second = create(f"{data_format}-second-v0", [episode(5, 20), episode(6, 21)], data_format)
    both = minari.combine_datasets([first, second], f"{data_format}-both-v0")
    print(f"{data_format} {seeds(first)} and {seeds(second)} make {seeds(both)}")
    assert (seeds(first), seeds(second)) == ([10, 11], [20, 21])
    assert seeds(both) == [None] * 4, "Minari behaves differently now"
EOF
