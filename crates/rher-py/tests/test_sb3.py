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


def test_hindsight_learns_from_a_vector():
    import torch
    from rher.sb3 import TaskVecEnv
    from stable_baselines3.common.vec_env import VecMonitor

    torch.set_num_threads(1)
    envs = VecMonitor(TaskVecEnv("rher/Push-v0", n_envs=4, seed=0))
    model = sb3.SAC(
        "MultiInputPolicy",
        envs,
        replay_buffer_class=sb3.HerReplayBuffer,
        replay_buffer_kwargs={"copy_info_dict": True},
        policy_kwargs={"net_arch": [32, 32]},
        learning_starts=400,
        gradient_steps=1,
        seed=0,
    )
    model.learn(2000)
    assert model.num_timesteps >= 2000 and len(model.ep_info_buffer) == 40
    assert all(episode["l"] == 50 for episode in model.ep_info_buffer)
    rewards = model.replay_buffer.sample(500).rewards
    assert 0 < (rewards == 0).float().mean() < 1, "hindsight has made some of them successes"
    mean, _ = sb3.common.evaluation.evaluate_policy(model, envs, n_eval_episodes=4)
    assert -50 <= mean <= 0


@pytest.mark.parametrize("reward_type", ["sparse", "dense"])
def test_a_vector_steps_like_that_of_sb3(reward_type):
    from rher.sb3 import TaskVecEnv
    from stable_baselines3.common.env_util import make_vec_env

    ours = TaskVecEnv("push", n_envs=3, seed=5, reward_type=reward_type)
    theirs = make_vec_env(
        lambda: gymnasium.make("rher/Push-v0", reward_type=reward_type), n_envs=3, seed=5
    )
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    theirs.seed(5)
    actions = np.random.default_rng(0).uniform(-1, 1, (120, 3, 4)).astype(np.float32)

    def same(one, other):
        assert one.keys() == other.keys()
        for key in one:
            assert one[key].dtype == other[key].dtype and np.array_equal(one[key], other[key])

    same(ours.reset(), theirs.reset())
    assert len(ours.reset_infos) == 3
    ends = 0
    for action in actions:
        one, other = ours.step(action), theirs.step(action)
        same(one[0], other[0])
        for index in (1, 2):
            assert one[index].dtype == other[index].dtype
            assert np.array_equal(one[index], other[index])
        for info, expected in zip(one[3], other[3]):
            expected.pop("episode", None)
            last, its = (each.pop("terminal_observation", None) for each in (info, expected))
            assert info == expected and (last is None) == (its is None)
            if last is not None:
                same(last, its)
                ends += 1
    assert ends == 6


def test_a_vector_is_copied_pickled_and_returned_to():
    import copy
    import pickle

    from rher.sb3 import TaskVecEnv

    envs = TaskVecEnv("rher/DPush-v0", n_envs=2, seed=1)
    envs.reset()
    action = np.ones((2, 4), np.float32)
    envs.step(action)
    state = envs.get_state()
    twins = [copy.deepcopy(envs), pickle.loads(pickle.dumps(envs))]
    expected = [envs.step(action)[0]["observation"] for _ in range(3)]
    envs.set_state(state)
    for each in (*twins, envs):
        assert np.array_equal([each.step(action)[0]["observation"] for _ in range(3)], expected)


def test_a_vector_begins_as_its_options_say():
    from rher.sb3 import TaskVecEnv

    envs = TaskVecEnv("push", n_envs=2, seed=0)
    goal = [1.3, 0.7, 0.42469]
    envs.set_options([{}, {"goal": goal}])
    first = envs.reset()["desired_goal"]
    assert np.allclose(first[1], goal, atol=1e-6) and not np.allclose(first[0], goal, atol=1e-3)
    assert not np.allclose(envs.reset()["desired_goal"][1], goal, atol=1e-3)
    envs.set_options({"goals": goal})
    with pytest.raises(rher.InputError, match="no option 'goals'"):
        envs.reset()


def test_what_single_environments_have_is_asked_for():
    from rher.sb3 import TaskVecEnv

    envs = TaskVecEnv("push", n_envs=3)
    assert envs.get_attr("distance_threshold") == pytest.approx([0.05] * 3)
    goals = np.zeros((7, 3))
    (rewards,) = envs.env_method("compute_reward", goals, goals, [{}] * 7, indices=[0])
    assert list(rewards) == [0.0] * 7
    assert envs.env_is_wrapped(gymnasium.Wrapper) == [False] * 3
    with pytest.raises(rher.InputError, match="`step` cannot be called for single environments"):
        envs.env_method("step", np.zeros(4))
    with pytest.raises(rher.InputError, match="`task` cannot be set"):
        envs.set_attr("task", "pick")
    with pytest.raises(AttributeError):
        envs.get_attr("wheels")
    with pytest.raises(rher.InputError, match="n_envs is 0"):
        TaskVecEnv("push", n_envs=0)


def test_sb3_films_a_vector(tmp_path):
    pytest.importorskip("moviepy")
    from rher.sb3 import TaskVecEnv
    from stable_baselines3.common.vec_env import VecVideoRecorder

    envs = TaskVecEnv("push", n_envs=2, seed=0, render_mode="rgb_array", width=96, height=64)
    films = VecVideoRecorder(envs, str(tmp_path), lambda step: step == 0, video_length=8)
    films.reset()
    assert films.render().shape == (64, 192, 3) or films.render().shape == (128, 96, 3)
    for _ in range(10):
        films.step(np.zeros((2, 4), np.float32))
    films.close()
    (film,) = tmp_path.glob("*.mp4")
    assert film.stat().st_size > 1000
