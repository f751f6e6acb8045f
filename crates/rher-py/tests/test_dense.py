"""Dense rewards: minus the distance to the goal."""

import gymnasium
import numpy as np
import pytest
import rher
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import SyncVectorEnv


def distance(observation):
    return np.linalg.norm(observation["achieved_goal"] - observation["desired_goal"], axis=-1)


def test_every_task_has_a_dense_id():
    assert list(rher.DENSE_IDS.values()) == list(rher.IDS.values())
    assert "rher/PushDense-v0" in rher.DENSE_IDS


@pytest.mark.parametrize("name", rher.DENSE_IDS)
@pytest.mark.filterwarnings("error")
def test_rewards_are_distances_and_what_compute_reward_says(name):
    env = gymnasium.make(name, render_mode="rgb_array").unwrapped
    check_env(env)
    observation, _ = env.reset(seed=2)
    seen, rewards = [], []
    for _ in range(5):
        observation, reward, _, _, info = env.step(env.action_space.sample())
        seen.append(observation)
        rewards.append(reward)
        sparse = gymnasium.make(name.replace("Dense", "")).unwrapped.compute_reward(
            observation["achieved_goal"], observation["desired_goal"], info
        )
        assert info["is_success"] == sparse + 1
    assert np.allclose(rewards, [-distance(one) for one in seen], atol=1e-6)
    achieved, desired = (
        np.array([one[key] for one in seen]) for key in ("achieved_goal", "desired_goal")
    )
    assert np.array_equal(env.compute_reward(achieved, desired, {}), rewards)
    batch = env.compute_reward(np.stack([achieved] * 3), np.stack([desired] * 3), {})
    assert batch.shape == (3, 5) and np.array_equal(batch[1], rewards)


def test_the_distance_is_that_of_gymnasium_robotics():
    robotics = pytest.importorskip("gymnasium_robotics")
    gymnasium.register_envs(robotics)
    theirs = gymnasium.make("FetchPushDense-v4").unwrapped
    ours = gymnasium.make("rher/PushDense-v0").unwrapped
    goals = np.random.default_rng(0).uniform(0, 1, (2, 7, 3)).astype(np.float32)
    expected = theirs.compute_reward(*goals, {})
    assert np.allclose(ours.compute_reward(*goals, {}), expected, atol=1e-6)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_vectors_reward_like_single_environments(mode):
    name = "rher/DPushDense-v0"
    ours = gymnasium.make_vec(name, num_envs=2, autoreset_mode=mode)
    theirs = SyncVectorEnv([lambda: gymnasium.make(name)] * 2, autoreset_mode=mode)
    ours.reset(seed=0), theirs.reset(seed=0)
    ours.action_space.seed(0)
    for _ in range(70):
        action = ours.action_space.sample()
        assert np.array_equal(ours.step(action)[1], theirs.step(action)[1])


def test_another_reward_type_is_refused():
    for make in (rher.TaskEnv, rher.TaskVectorEnv):
        with pytest.raises(rher.InputError, match="reward_type is 'rich', expected 'sparse' or"):
            make("push", reward_type="rich")
