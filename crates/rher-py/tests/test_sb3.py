"""Stable-Baselines3 on our environments."""

import gymnasium
import numpy as np
import pytest
import rher

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


def test_a_policy_is_evaluated_like_a_model(tmp_path):
    from stable_baselines3.common.evaluation import evaluate_policy

    tiny = {"agent.hidden": [16, 16], "replay.batch_size": 16, "evaluation.episodes": 2}
    policy = rher.train("reach", set=tiny, env_steps=100, out=tmp_path / "run").policy
    env = gymnasium.make("rher/Reach-v0")
    observation, _ = env.reset(seed=0)
    action, state = policy.predict(observation, deterministic=True)
    assert state is None and np.array_equal(action, policy(observation))
    mean, deviation = evaluate_policy(policy, env, n_eval_episodes=2, warn=False)
    assert -env.spec.max_episode_steps <= mean <= 0 and deviation >= 0


def test_the_version_is_that_of_the_package():
    from importlib.metadata import version

    assert rher.__version__ == version("rher")
