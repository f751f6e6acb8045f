#!/usr/bin/env bash
# Minari 0.5.4: two datasets in Parquet or Arrow storage whose infos are one number for each frame, both
# readable, are combined without a word to a dataset that cannot be read. So is any dataset that is
# stored with such an info as a NumPy vector; as a list of the same numbers it can be read.
#
# A good guess: an array and a list of the same numbers are stored alike, and datasets with equal
# columns can be combined.
#
# Seen:
#   parquet list [0 1 2 3 4 5]
#   parquet array ValueError: invalid literal for int() with base 10: b''
#   parquet combined lists ValueError: invalid literal for int() with base 10: b''
#   arrow list [0 1 2 3 4 5]
#   arrow array ValueError: invalid literal for int() with base 10: b''
#   arrow combined lists ValueError: invalid literal for int() with base 10: b''
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


def battery(dataset):
    try:
        return list(next(iter(dataset.iterate_episodes())).infos["battery"])
    except ValueError as error:
        return f"ValueError: {error}"


for data_format in ["parquet", "arrow"]:
    numbers = list(range(6))

    def of(name, values):
        infos = {"battery": values}
        return create(f"{data_format}-{name}-v0", [episode(5, 1, infos=infos)], data_format)

    lists, again = of("list", numbers), of("again", numbers)
    both = minari.combine_datasets([lists, again], f"{data_format}-both-v0")
    seen = {
        "list": battery(lists),
        "array": battery(of("array", np.arange(6))),
        "combined lists": battery(both),
    }
    for name, found in seen.items():
        print(data_format, name, found if isinstance(found, str) else np.array(found))
    unreadable = "ValueError: invalid literal for int() with base 10: b''"
    expected = {"list": numbers, "array": unreadable, "combined lists": unreadable}
    assert seen == expected, "Minari behaves differently now"
EOF
