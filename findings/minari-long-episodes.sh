#!/usr/bin/env bash
# Minari 0.5.4 with pyarrow 26.0.1: of an episode of more than 32,767 steps in its Parquet or Arrow
# storage, the readers return the first 32,767 steps under its number, and the next piece of it under
# the number of the next episode, which is lost. Nothing is said.
#
# A good guess: episodes come back as they were stored, whatever their length. The reader pairs
# episode numbers with record batches, and a long episode is read in several.
#
# Seen: an episode of 40,000 steps and one of 5 are read as
#   parquet [(0, 32767), (1, 7232)]
#   arrow [(0, 32767), (1, 7232)]
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


seen = {}
for data_format in ["parquet", "arrow"]:
    dataset = create(f"{data_format}-v0", [episode(40_000, 1), episode(5, 2)], data_format)
    seen[data_format] = [(int(e.id), len(e.rewards)) for e in dataset.iterate_episodes()]
    print(data_format, seen[data_format])
expected = [(0, 32767), (1, 7232)]
assert seen == {"parquet": expected, "arrow": expected}, "Minari behaves differently now"
EOF
