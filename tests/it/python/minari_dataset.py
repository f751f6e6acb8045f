"""Opens a dataset with Minari, and prints what is in it as JSON."""

import json
import sys

import minari
import numpy as np



def limits(space):
    return [float(space.low.min()), float(space.high.max())]


dataset = minari.MinariDataset(sys.argv[1])
episodes = list(dataset.iterate_episodes())
first = episodes[0]
assert all(dataset.action_space.contains(action) for action in first.actions)
for step in range(first.rewards.size + 1):
    observation = {name: rows[step] for name, rows in first.observations.items()}
    assert dataset.observation_space.contains(observation)
print(
    json.dumps(
        {
            "id": dataset.spec.dataset_id,
            "total_episodes": int(dataset.total_episodes),
            "total_steps": int(dataset.total_steps),
            "sampled": len(dataset.sample_episodes(2)),
            "ids": [int(episode.id) for episode in episodes],
            "observations": {
                name: list(rows.shape) for name, rows in first.observations.items()
            },
            "actions": list(first.actions.shape),
            "rewards": list(first.rewards.shape),
            "truncated_at": [int(np.flatnonzero(episode.truncations)[0]) for episode in episodes],
            "terminated": bool(any(episode.terminations.any() for episode in episodes)),
            "successes": list(first.infos["is_success"].shape),
            "kinds": {
                "observations": str(dataset.observation_space["observation"].dtype),
                "actions": str(dataset.action_space.dtype),
            },
            "limits": {
                "observations": limits(dataset.observation_space["achieved_goal"]),
                "actions": limits(dataset.action_space),
            },
            "size": [
                dataset.storage.metadata.get("dataset_size"),
                float(dataset.storage.get_size()),
            ],
            "seeds": [metadata.get("seed") for metadata in dataset.storage.get_episode_metadata([0, 1])],
            "last_observation": first.observations["observation"][-1].tolist(),
            "last_action": first.actions[-1].tolist(),
        }
    )
)
