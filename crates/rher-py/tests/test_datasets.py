"""Datasets that the program exports, in the environments of this package."""

import os
import subprocess

import gymnasium
import numpy as np
import pytest

import rher

minari = pytest.importorskip("minari")
from minari.data_collector import EpisodeBuffer  # noqa: E402

#: The program, where the tests of the workspace run these.
PROGRAM = os.environ.get("RHER")
pytestmark = pytest.mark.skipif(PROGRAM is None, reason="the variable RHER names no program")

TINY = "--until 0 --set agent.hidden=[16,16] --set replay.batch_size=16 --env-steps 1".split()


def run(folder, *arguments):
    subprocess.run([PROGRAM, *arguments], cwd=folder, check=True, capture_output=True)


def exported(folder, task, dataset_id, *settings):
    """A dataset of two episodes of an untrained policy."""
    out = os.path.join("minari", dataset_id)
    run(folder, "train", task, "--out", dataset_id, *TINY, *settings)
    run(folder, "export", dataset_id, "--format", "minari", "--out", out, "--episodes", "2",
        "--dataset-id", dataset_id)  # fmt: skip
    return minari.MinariDataset(os.path.join(folder, out, "data"))


@pytest.mark.parametrize("name", sorted(rher.IDS))
def test_a_dataset_recovers_the_environment_of_its_task(name, tmp_path):
    dataset = exported(tmp_path, rher.IDS[name], "rher/one-v0")
    assert dataset.spec.env_spec == gymnasium.make(name).spec
    for env in [dataset.recover_environment(), dataset.recover_environment(eval_env=True)]:
        assert env.observation_space == dataset.observation_space
        assert env.action_space == dataset.action_space
        env.close()


def replay(env, dataset):
    """Plays every episode of a dataset again from its seed, and compares it bit for bit."""
    seeds = [metadata["seed"] for metadata in dataset.storage.get_episode_metadata([0, 1])]
    for episode, seed in zip(dataset.iterate_episodes(), seeds):
        observation, info = env.reset(seed=seed)
        for step in range(len(episode.actions) + 1):
            for key, rows in episode.observations.items():
                assert np.array_equal(rows[step], observation[key]), (key, step)
            assert episode.infos["is_success"][step] == info["is_success"]
            if step < len(episode.actions):
                observation, reward, terminated, truncated, info = env.step(episode.actions[step])
                assert reward == episode.rewards[step]
                assert terminated == episode.terminations[step]
                assert truncated == episode.truncations[step]


def test_a_recovered_environment_repeats_the_dataset(tmp_path):
    dataset = exported(tmp_path, "push", "rher/push-v3")
    replay(dataset.recover_environment(), dataset)


def test_a_recovered_environment_has_the_options_of_the_run(tmp_path):
    settings = [
        "--set", "task.noise=0.003",
        "--set", "randomize.friction=[0.7,1.5]",
        "--set", "randomize.action_delay=[0,2]",
    ]  # fmt: skip
    dataset = exported(tmp_path, "cue-push", "rher/cue-push-v1", *settings)
    env = gymnasium.make(
        "rher/CuePush-v0",
        options={"noise": 0.003},
        randomize={"friction": [0.7, 1.5], "action_delay": [0, 2]},
    )
    assert dataset.spec.env_spec == env.spec
    replay(dataset.recover_environment(), dataset)


def test_a_dataset_combines_with_one_that_minari_collected(tmp_path, monkeypatch):
    root = tmp_path / "minari"
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(root))
    ours = exported(tmp_path, "push", "rher/ours-v0")
    env = gymnasium.make("rher/Push-v0")
    observation, _ = env.reset(seed=0)
    frames, actions, rewards, truncations = [observation], [], [], []
    while not truncations or not truncations[-1]:
        actions.append(env.action_space.sample())
        observation, reward, _, truncated, _ = env.step(actions[-1])
        frames.append(observation)
        rewards.append(reward)
        truncations.append(truncated)
    episode = EpisodeBuffer(
        seed=0,
        observations={key: np.stack([frame[key] for frame in frames]) for key in observation},
        actions=np.stack(actions),
        rewards=rewards,
        terminations=[False] * len(actions),
        truncations=truncations,
    )
    # As Minari's `DataCollector` stores it, without the packages that it needs.
    theirs = minari.create_dataset_from_buffers(
        "rher/theirs-v0", buffer=[episode], env=env, data_format="parquet"
    )
    both = minari.combine_datasets([ours, theirs], "rher/both-v0")
    assert both.spec.env_spec == env.spec
    assert [len(episode.rewards) for episode in both.iterate_episodes()] == [50, 50, 50]
