"""Datasets that the program exports, read by d3rlpy, and compared with what Minari reads."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from test_datasets import PROGRAM, exported

pytestmark = [
    pytest.mark.skipif(PROGRAM is None, reason="the variable RHER names no program"),
    pytest.mark.skipif(importlib.util.find_spec("d3rlpy") is None, reason="there is no d3rlpy"),
]

DATASET = "rher/reach-v0"
SCRIPT = Path(__file__).with_name("with_d3rlpy.py")


@pytest.fixture(scope="module")
def read(tmp_path_factory):
    """The episodes that Minari reads, and what the script saves.

    Its own process leaves the other tests without d3rlpy's old `gym`."""
    folder = tmp_path_factory.mktemp("d3rlpy")
    episodes = list(exported(folder, "reach", DATASET).iterate_episodes())
    out = folder / "read.npz"
    command = [sys.executable, "-W", "ignore", SCRIPT, DATASET, out]
    environ = os.environ | {"MINARI_DATASETS_PATH": str(folder / "minari")}
    ended = subprocess.run(command, capture_output=True, text=True, env=environ)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return episodes, np.load(out)


def rows(episode):
    """The observations of an episode, each with its goal."""
    return np.hstack([episode.observations[key] for key in ["observation", "desired_goal"]])


def test_d3rlpy_loads_a_dataset_with_its_environment(read):
    episodes, saved = read
    assert saved["spec"] == "rher/Reach-v0"
    assert sum(name.startswith("loaded_actions") for name in saved) == len(episodes)
    for index, episode in enumerate(episodes):
        assert np.array_equal(saved[f"loaded_actions_{index}"], episode.actions)
        assert np.array_equal(saved[f"loaded_rewards_{index}"][:, 0], episode.rewards)
        assert not saved[f"loaded_terminated_{index}"]
    # Those of later episodes are of the wrong steps.
    assert np.array_equal(saved["loaded_observations_0"], rows(episodes[0])[:-1])


def test_d3rlpy_learns_from_the_transitions_of_a_dataset(read):
    episodes, saved = read
    assert sum(name.startswith("action_") for name in saved) == len(episodes)
    for index, episode in enumerate(episodes):
        # d3rlpy has no use for the last step of an episode that is cut off.
        steps = len(episode.actions) - 1
        assert np.array_equal(saved[f"observation_{index}"], rows(episode)[:steps])
        assert np.array_equal(saved[f"action_{index}"], episode.actions[:steps])
        assert np.array_equal(saved[f"reward_{index}"][:, 0], episode.rewards[:steps])
        assert np.array_equal(saved[f"next_observation_{index}"], rows(episode)[1 : steps + 1])
        assert not saved[f"terminal_{index}"].any()
