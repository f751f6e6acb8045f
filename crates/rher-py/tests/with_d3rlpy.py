"""Reads a Minari dataset with d3rlpy, and saves the transitions that it learns from.

d3rlpy's own loader, `get_minari`, loads it, too: its episodes are saved as they come.
"""

import sys

import d3rlpy
import minari
import numpy as np

dataset_id, out = sys.argv[1:]
saved = {}

loaded, env = d3rlpy.datasets.get_minari(dataset_id)
saved["spec"] = env.spec.id
for index, episode in enumerate(loaded.episodes):
    for name in ["observations", "actions", "rewards", "terminated"]:
        saved[f"loaded_{name}_{index}"] = getattr(episode, name)

episodes = list(minari.load_dataset(dataset_id).iterate_episodes())
dataset = d3rlpy.dataset.MDPDataset(
    observations=np.concatenate([
        np.hstack([episode.observations[key] for key in ["observation", "desired_goal"]])[:-1]
        for episode in episodes
    ]),
    actions=np.concatenate([episode.actions for episode in episodes]),
    rewards=np.concatenate([episode.rewards for episode in episodes]),
    terminals=np.concatenate([episode.terminations for episode in episodes]),
    timeouts=np.concatenate([episode.truncations for episode in episodes]),
)
for index, episode in enumerate(dataset.episodes):
    transitions = [
        dataset.transition_picker(episode, step) for step in range(episode.transition_count)
    ]
    for name in ["observation", "action", "reward", "next_observation", "terminal"]:
        rows = [np.ravel(getattr(transition, name)) for transition in transitions]
        saved[f"{name}_{index}"] = np.stack(rows)
np.savez(out, **saved)
