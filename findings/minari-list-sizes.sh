#!/usr/bin/env bash
# Minari 0.5.4: one dataset whose metadata have no `dataset_size` makes `minari list local` end in a
# KeyError, so that none of the user's other datasets is listed either. `load_dataset` and
# `list_local_datasets` accept the same dataset.
#
# A good guess: a size that is missing is shown as unknown, or that one dataset is left out.
#
# Seen:
#   loaded: 1 episodes
#   known: ['good-v0', 'old-v0']
#   listing: KeyError: 'dataset_size'
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


import json
import os

from minari.cli import list_cmd

create("good-v0", [episode(5, 1)], "parquet")
create("old-v0", [episode(5, 1)], "parquet")
path = os.path.join(os.environ["MINARI_DATASETS_PATH"], "old-v0", "data", "metadata.json")
with open(path) as file:
    metadata = json.load(file)
del metadata["dataset_size"]
with open(path, "w") as file:
    json.dump(metadata, file)

print("loaded:", minari.load_dataset("old-v0").total_episodes, "episodes")
print("known:", sorted(minari.list_local_datasets()))
try:
    list_cmd("local", all=False, prefix=None)
    raise SystemExit("Minari behaves differently now")
except KeyError as error:
    print("listing: KeyError:", error)
    assert error.args == ("dataset_size",)
EOF
