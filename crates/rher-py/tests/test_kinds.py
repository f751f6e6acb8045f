"""Environments of every kind that the agent can learn: how they end, and what their numbers are."""

import gymnasium
import numpy as np
import pytest
import rher
import rher.onnx
from toy import STEPS, Carry, Ending, Flat


def trainer(env, tiny, out, **arguments):
    return rher.Trainer(env, **({"set": tiny, "out": out, "episode_steps": STEPS} | arguments))


def share_solved(env, policy, episodes=20):
    """How many episodes end within the tolerance, played by a policy that acts as it is."""
    solved = 0
    for seed in range(episodes):
        seen, _ = env.reset(seed=1000 + seed)
        over = False
        while not over:
            seen, _, terminated, truncated, _ = env.step(policy(seen))
            over = terminated or truncated
        solved += np.linalg.norm(seen["achieved_goal"] - seen["desired_goal"]) <= 0.1
    return solved / episodes


SIZES = {"agent.hidden": [64, 64], "evaluation.every_episodes": 50, "evaluation.episodes": 50}


@pytest.mark.parametrize("says_so", [True, False], ids=["is_success", "silent"])
def test_it_learns_where_episodes_end(says_so, out):
    env = Ending(1, says_so)
    run = trainer(env, {}, out, set=SIZES, workers=1).learn(env_steps=12_000, until=0.9)
    assert run.metrics["success_final"].max() >= 0.9
    assert share_solved(env, run.policy) >= 0.7
    assert {end for _, end in env.ends} >= {"solved"}


def test_steps_are_those_that_were_taken(tiny, out):
    env = Ending(1)
    run = trainer(env, tiny | {"evaluation.every_episodes": 1000}, out)
    env.ends.clear()
    run.learn(env_steps=10 * STEPS)
    # Seven episodes of evaluation follow.
    taken = [steps for steps, _ in env.ends][:-7]
    assert run.env_steps == sum(taken) and min(taken) < STEPS


def test_a_run_of_episodes_that_end_is_resumed(tiny, out):
    with trainer(Ending(1), tiny, out) as first:
        first.learn(env_steps=15 * STEPS)
        taken = first.env_steps
    resumed = rher.Trainer(Ending(1), episode_steps=STEPS, resume=out)
    assert resumed.env_steps == taken >= 15 * STEPS
    assert resumed.learn(env_steps=40 * STEPS).metrics["env_steps"][-1] >= 40 * STEPS


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_actions_have_the_limits_of_the_environment(dtype, out):
    low, high = np.array([-0.3, 0.0], dtype), np.array([0.1, 7.0], dtype)
    played = []

    class Scaled(gymnasium.Wrapper):
        def step(self, action):
            assert self.action_space.contains(action), action
            played.append(action)
            return super().step(np.clip(2 * (action - low) / (high - low) - 1, -1, 1).astype("f4"))

    watched = Scaled(Ending(1))
    watched.action_space = gymnasium.spaces.Box(low, high, dtype=dtype)
    run = trainer(watched, {}, out, set=SIZES, workers=1).learn(env_steps=12_000, until=0.9)
    ends = np.min(played, axis=0), np.max(played, axis=0)
    assert np.allclose(ends, (low, high))
    # The policy acts in the environment's units, also when it is read from its file.
    assert share_solved(watched, run.policy) >= 0.7
    with pytest.raises(rher.PolicyError, match="expected actions within -1 and 1"):
        rher.onnx.export(run, run.path / "policy.onnx")
    seen, _ = watched.reset(seed=0)
    assert watched.action_space.contains(rher.Policy.load(run.path / "policy.safetensors")(seen))


@pytest.mark.parametrize("objects", [0, 1, 2])
def test_positions_may_have_two_numbers(objects, tiny, out):
    env = Flat(Carry(objects))
    run = trainer(env, tiny, out, objects=objects).learn(env_steps=10 * STEPS)
    seen, _ = env.reset(seed=0)
    action = run.policy(seen)
    assert np.array_equal(run.policy(seen["observation"], seen["desired_goal"]), action)
    again = rher.Policy.load(run.path / "policy.safetensors")
    assert np.array_equal(again(seen), action)
    with pytest.raises(rher.PolicyError, match="positions of three numbers"):
        rher.onnx.export(run, out / "policy.onnx")
    with pytest.raises(rher.InputError, match="goal has shape"):
        run.policy(seen["observation"], np.zeros(3 * max(objects, 1)))


def test_the_gripper_has_as_many_numbers_as_a_position(tiny, out):
    with pytest.raises(rher.InputError, match="gripper is .*, expected 3 of the 6 numbers"):
        trainer(Carry(1), tiny, out, gripper=slice(0, 2))
    with pytest.raises(rher.InputError, match="gripper is .*, expected 2 of the 4 numbers"):
        trainer(Flat(Carry(1)), tiny, out, gripper=slice(0, 3))


def test_how_long_episodes_are_is_found_out(tiny, out):
    found = trainer(Carry(1), tiny, out, episode_steps=None)
    assert found.learn(env_steps=1).metrics["env_steps"].tolist() == [STEPS]

    class Endless(Carry):
        def step(self, action):
            return *super().step(action)[:3], False, {}

    with pytest.raises(rher.InputError, match="episode_steps is not known"):
        trainer(Endless(1), tiny, out, episode_steps=None)
    assert trainer(Endless(1), tiny, out.with_name("endless")).learn(env_steps=STEPS)
