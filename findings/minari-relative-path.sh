#!/usr/bin/env bash
# Minari 0.5.4: where `MINARI_DATASETS_PATH` is a relative path, no dataset can be created, in any storage:
# the path of its files is looked up below itself. Datasets that are there can be listed and loaded.
#
# A good guess: a path that a program is given leads to the same folder from wherever it is looked up.
#
# Seen:
#   parquet: absolute path 2 episodes, relative path FileNotFoundError
#   arrow: absolute path 2 episodes, relative path FileNotFoundError
#   hdf5: absolute path 2 episodes, relative path FileNotFoundError
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
  'minari[arrow,hdf5]==0.5.4' gymnasium==1.4.0 numpy==2.4.6 pillow==12.0.0 pyarrow==26.0.1
cd "$folder"
"$folder/venv/bin/python" -W ignore - <<'EOF'
import os
from pathlib import Path

import gymnasium
import minari
import numpy as np
from minari.data_collector import EpisodeBuffer


def episode(steps, seed):
    """An episode of CartPole's spaces that is cut off after so many steps."""
    return EpisodeBuffer(
        seed=seed,
        observations=np.zeros((steps + 1, 4), np.float32),
        actions=np.zeros(steps, np.int64),
        rewards=[1.0] * steps,
        terminations=[False] * steps,
        truncations=[False] * (steps - 1) + [True],
    )


def created(path, data_format):
    """What comes of a dataset of two episodes in a folder that is named so."""
    Path(path).mkdir()
    os.environ["MINARI_DATASETS_PATH"] = str(path)
    buffer = [episode(5, 1), episode(6, 2)]
    env = gymnasium.make("CartPole-v1")
    try:
        dataset = minari.create_dataset_from_buffers(
            "first-v0", buffer=buffer, env=env, data_format=data_format
        )
    except FileNotFoundError as error:
        return type(error).__name__
    return f"{dataset.total_episodes} episodes"


for data_format in ("parquet", "arrow", "hdf5"):
    absolute = created(Path.cwd() / f"{data_format}-absolute", data_format)
    relative = created(f"{data_format}-relative", data_format)
    print(f"{data_format}: absolute path {absolute}, relative path {relative}")
    assert absolute == "2 episodes"
    assert relative == "FileNotFoundError", "Minari behaves differently now"
EOF
