"""Whatever the memory of an array looks like, its numbers are what its indices say.

Each entry point is compared with itself, given plain arrays, and rewards with NumPy.
"""

import gymnasium
import numpy as np
import pytest
import rher
from layouts import ARRANGEMENTS, TYPES, arranged, broadcast
from test_vector import assert_same
from toy import STEPS, Carry

DRAWS = 40


def plain(array):
    return np.array(array, np.float32, order="C")


def named(arrange):
    return arrange.__name__.strip("_")


def rewards(achieved, desired):
    """Of tasks that place objects: 0 where each of them is within 5 cm."""
    apart = np.subtract(achieved, desired, dtype=np.float64)
    apart = apart.reshape(*np.shape(achieved)[:-1], np.shape(achieved)[-1] // 3, 3)
    return np.where((np.linalg.norm(apart, axis=-1) < 0.05).all(axis=-1), 0.0, -1.0)


def goals(rng, shape, objects, dtype):
    """Two goals that are near each other in about half of the rows, and never at 5 cm exactly."""
    whole = np.issubdtype(dtype, np.integer)
    if whole:
        achieved = rng.integers(0, 3, (*shape, 3 * objects)).astype(dtype)
        near = achieved
    else:
        # Sixteenths of a meter are exact in every type: half a centimeter would not be.
        achieved = (rng.integers(0, 16, (*shape, 3 * objects)) / 16).astype(dtype)
        near = achieved + np.asarray(1 / 64, dtype)
    is_near = rng.random((*shape, 1)) < 0.5
    far = achieved + np.asarray(1, dtype)
    return achieved, np.where(is_near, near, far).astype(dtype)


@pytest.mark.parametrize("name", ["rher/Push-v0", "rher/DPush-v0", "rher/TStack-v0"])
@pytest.mark.parametrize("together", [False, True], ids=["single", "vector"])
def test_rewards_are_those_of_numpy(name, together):
    env = gymnasium.make_vec(name, num_envs=2) if together else gymnasium.make(name).unwrapped
    objects = rher.TaskEnv(rher.IDS[name]).objects
    rng = np.random.default_rng(0)
    solved = 0
    for _ in range(DRAWS):
        shape = tuple(rng.integers(0, 6, rng.integers(0, 3)))
        achieved, desired = goals(rng, shape, objects, TYPES[rng.integers(len(TYPES))])
        expected = rewards(achieved, desired)
        solved += (expected == 0).sum()
        found = env.compute_reward(arranged(achieved, rng), arranged(desired, rng), {})
        assert np.array_equal(found, expected)
    assert solved > 20


@pytest.mark.parametrize("arrange", ARRANGEMENTS, ids=named)
@pytest.mark.parametrize("dtype", TYPES)
def test_rewards_in_each_arrangement(arrange, dtype):
    env = gymnasium.make("rher/DPush-v0").unwrapped
    achieved, desired = goals(np.random.default_rng(1), (9,), 2, dtype)
    expected = rewards(achieved, desired)
    assert set(expected) == {0, -1}
    for one, other in [(arrange(achieved), desired), (achieved, arrange(desired))]:
        assert np.array_equal(env.compute_reward(one, other, {}), expected)


def test_rewards_of_one_goal_seen_many_times():
    env = gymnasium.make("rher/Push-v0").unwrapped
    achieved, _ = goals(np.random.default_rng(2), (4, 5), 1, np.float32)
    desired = broadcast(achieved[0, 0] + np.float32(1 / 64), (4, 5))
    assert 0 in desired.strides
    found = env.compute_reward(achieved, desired, {})
    assert np.array_equal(found, rewards(achieved, desired)) and found[0, 0] == 0
    number = np.broadcast_to(np.float32(0.5), (4, 5, 3))
    assert np.array_equal(env.compute_reward(number, number, {}), np.zeros((4, 5)))


@pytest.mark.parametrize("wrong", [1j, "near", None, np.nan, np.inf])
def test_goals_that_are_not_numbers_are_refused(wrong):
    env = gymnasium.make("rher/Push-v0").unwrapped
    with pytest.raises(rher.InputError, match="desired.goal"):
        env.compute_reward(np.zeros((2, 3)), np.full((2, 3), wrong), {})


@pytest.mark.parametrize("arrange", ARRANGEMENTS, ids=named)
@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int8])
def test_steps_in_each_arrangement(arrange, dtype):
    rng = np.random.default_rng(3)
    one, other = (gymnasium.make("rher/Push-v0").unwrapped for _ in "ab")
    many, more = (gymnasium.make_vec("rher/Push-v0", num_envs=5) for _ in "ab")
    for env in (one, other, many, more):
        env.reset(seed=0)
    for _ in range(4):
        actions = rng.uniform(-1.5, 1.5, (5, 4)).astype(dtype)
        assert_same(many.step(arrange(actions)), more.step(plain(actions)))
        seen, expected = one.step(arrange(actions[0]))[0], other.step(plain(actions[0]))[0]
        assert_same(seen, expected)


def test_steps_with_one_action_for_all():
    many, more = (gymnasium.make_vec("rher/Push-v0", num_envs=5) for _ in "ab")
    assert_same(many.reset(seed=0), more.reset(seed=0))
    action = broadcast(np.array([0.3, -0.4, 0.5, 1.0], np.float32), (5,))
    assert_same(many.step(action), more.step(plain(action)))
    zeros = np.broadcast_to(np.float32(0.25), (5, 4))
    assert_same(many.step(zeros), more.step(plain(zeros)))


@pytest.fixture(scope="module")
def policy(tmp_path_factory):
    sizes = {"agent.hidden": [16, 16], "replay.batch_size": 16, "evaluation.episodes": 2}
    out = tmp_path_factory.mktemp("policy") / "run"
    return rher.train("dpush", set=sizes, env_steps=100, out=out).policy


@pytest.mark.parametrize("arrange", ARRANGEMENTS, ids=named)
def test_policies_in_each_arrangement(arrange, policy):
    seen, _ = gymnasium.make_vec("rher/DPush-v0", num_envs=6).reset(seed=0)
    seen = {key: plain(array) for key, array in seen.items()}
    expected = policy(seen)
    assert len(np.unique(expected, axis=0)) == 6
    assert np.array_equal(policy({key: arrange(array) for key, array in seen.items()}), expected)
    parts = arrange(seen["observation"]), arrange(seen["desired_goal"])
    assert np.array_equal(policy(*parts), expected)
    row = arrange(seen["observation"][0]), arrange(seen["desired_goal"][0])
    assert np.array_equal(policy(*row), expected[0])


def test_states_remember_actions_in_each_arrangement():
    one, other = (gymnasium.make("rher/Push-v0").unwrapped for _ in "ab")
    rng = np.random.default_rng(4)
    for env in (one, other):
        env.reset(seed=0)
    for _ in range(6):
        action = rng.uniform(-1, 1, 4).astype(np.float32)
        one.step(arranged(action, rng))
        other.step(action)
    assert one.get_state().__reduce__()[1] == other.get_state().__reduce__()[1]


@pytest.mark.parametrize("arrange", ARRANGEMENTS, ids=named)
def test_masks_seeds_and_options_in_each_arrangement(arrange):
    many, more = (
        gymnasium.make_vec("rher/Push-v0", num_envs=3, randomize={"friction": friction})
        for friction in (arrange(np.array([0.5, 1.5])), (0.5, 1.5))
    )
    seeds = np.array([3, 1, 2])
    assert_same(many.reset(seed=arrange(seeds)), more.reset(seed=[3, 1, 2]))
    mask = np.array([True, False, True])
    masks = [{"reset_mask": np.asarray(arrange(mask))}, {"reset_mask": mask}]
    assert_same(*(env.reset(options=options) for env, options in zip((many, more), masks)))


class Arranged(Carry):
    """Returns its arrays in random arrangements."""

    def __init__(self, seed):
        super().__init__(2)
        self.rng = None if seed is None else np.random.default_rng(seed)

    def seen(self):
        seen = super().seen()
        if self.rng is None:
            return seen
        return {key: arranged(array, self.rng) for key, array in seen.items()}


def test_environments_of_users_may_return_any_arrangement(tiny, tmp_path):
    runs = [
        rher.Trainer(
            Arranged(seed), objects=2, episode_steps=STEPS, set=tiny, out=tmp_path / str(seed)
        ).learn(env_steps=10 * STEPS)
        for seed in (None, 0, 1)
    ]
    for run in runs[1:]:
        for key in ("critic_loss", "final_distance"):
            assert np.array_equal(run.metrics[key], runs[0].metrics[key]), key
