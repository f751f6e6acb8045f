"""Stable-Baselines3 on our environments."""

import gymnasium
import numpy as np
import pytest
import rher  # noqa: F401

sb3 = pytest.importorskip("stable_baselines3")


def success(model, env, episodes=50):
    """Share of episodes that the deterministic policy solves."""
    solved = 0
    for seed in range(episodes):
        observation, info = env.reset(seed=seed)
        done = False
        while not done:
            action, _ = model.predict(observation, deterministic=True)
            observation, _, terminated, truncated, info = env.step(action)
            done = terminated or truncated
        solved += info["is_success"]
    return solved / episodes


def test_hindsight_learns_to_reach():
    import torch

    torch.set_num_threads(1)
    env = gymnasium.make("rher/Reach-v0")
    model = sb3.TD3(
        "MultiInputPolicy",
        env,
        replay_buffer_class=sb3.HerReplayBuffer,
        policy_kwargs={"net_arch": [64, 64]},
        action_noise=sb3.common.noise.NormalActionNoise(np.zeros(4), 0.2 * np.ones(4)),
        gamma=0.95,
        learning_rate=1e-3,
        tau=0.02,
        learning_starts=500,
        seed=0,
    )
    for _ in range(12):
        model.learn(1000, reset_num_timesteps=False)
        if success(model, env) == 1.0:
            return
    pytest.fail("TD3 with hindsight did not learn to reach")
