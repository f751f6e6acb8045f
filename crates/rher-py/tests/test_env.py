"""Single environments: the interface, seeds, copies, and what is refused."""

import copy
import pickle
import threading
import warnings

import gymnasium
import numpy as np
import pytest
import rher
from gymnasium.utils.env_checker import check_env

FETCH = {"rher/Reach-v0": 10, "rher/Push-v0": 25, "rher/PickAndPlace-v0": 25, "rher/Slide-v0": 25}


@pytest.fixture
def env():
    env = gymnasium.make("rher/Push-v0")
    yield env
    env.close()


def play(env, steps, seed=0):
    """Observations of random actions, which are those of the seed."""
    rng = np.random.default_rng(seed)
    actions = rng.uniform(-1, 1, (steps, *env.action_space.shape)).astype(np.float32)
    return [env.step(action)[0]["observation"] for action in actions]


@pytest.mark.parametrize("name", rher.IDS)
def test_gymnasium_and_sb3_have_nothing_to_complain_of(name):
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(name, render_mode="rgb_array").unwrapped)
        checker.check_env(gymnasium.make(name).unwrapped)


def test_there_is_an_id_for_every_task():
    assert sorted(rher.IDS.values()) == sorted(rher.tasks())


@pytest.mark.parametrize(("name", "width"), FETCH.items())
def test_shapes_and_types_are_those_of_fetch(name, width):
    env = gymnasium.make(name)
    observation, info = env.reset(seed=0)
    assert {key: (value.shape, value.dtype.name) for key, value in observation.items()} == {
        "observation": ((width,), "float64"),
        "achieved_goal": ((3,), "float64"),
        "desired_goal": ((3,), "float64"),
    }
    assert (env.action_space.shape, env.action_space.dtype.name) == ((4,), "float32")
    assert info["is_success"] in (0.0, 1.0)


@pytest.mark.parametrize(("name", "objects"), [("rher/DPush-v0", 2), ("rher/TStack-v0", 3)])
def test_goals_are_as_wide_as_there_are_objects(name, objects):
    env = gymnasium.make(name)
    observation, _ = env.reset(seed=3)
    assert observation["desired_goal"].shape == (3 * objects,)
    # Objects lie on the table, each at its own place.
    places = observation["achieved_goal"].reshape(objects, 3)
    assert np.ptp(places[:, 2]) < 1e-3 and len(np.unique(places[:, 0])) == objects


def test_a_seed_repeats_a_run_of_episodes_and_each_is_another(env):
    def starts():
        return [env.reset(seed=7)[0]["observation"]] + [env.reset()[0]["observation"] for _ in "ab"]

    first, second = starts(), starts()
    assert np.array_equal(first, second)
    assert len(np.unique(first, axis=0)) == 3
    assert not np.array_equal(env.reset(seed=8)[0]["observation"], first[0])


def test_without_a_seed_every_environment_starts_elsewhere():
    starts = [gymnasium.make("rher/Push-v0").reset()[0]["observation"] for _ in "ab"]
    assert not np.array_equal(*starts)


def test_episodes_end_after_fifty_steps_and_not_before(env):
    env.reset(seed=0)
    ends = [env.step(env.action_space.sample())[2:4] for _ in range(50)]
    assert ends == [(False, False)] * 49 + [(False, True)]


def test_rewards_are_what_compute_reward_says(env):
    observation, _ = env.reset(seed=1)
    achieved, desired, rewards = [], [], []
    for _ in range(50):
        observation, reward, _, _, info = env.step(env.action_space.sample())
        achieved.append(observation["achieved_goal"])
        desired.append(observation["desired_goal"])
        rewards.append(reward)
        assert info["is_success"] == reward + 1
    task = env.unwrapped
    assert np.array_equal(task.compute_reward(np.array(achieved), np.array(desired), None), rewards)
    assert task.compute_reward(achieved[0], achieved[0], None) == 0
    far = achieved[0] + [0.051, 0, 0]
    assert task.compute_reward(achieved[0], far, None) == -1
    batch = task.compute_reward(np.zeros((4, 5, 3)), np.zeros((4, 5, 3)), None)
    assert batch.shape == (4, 5) and batch.dtype == np.float32


def test_all_objects_have_to_be_at_their_places():
    task = gymnasium.make("rher/DPush-v0").unwrapped
    goal = np.arange(6.0)
    one_off = goal + [0, 0, 0, 0.1, 0, 0]
    assert list(task.compute_reward(np.array([goal, one_off]), np.array([goal, goal]), None)) == [0, -1]


@pytest.mark.parametrize("name", ["rher/Push-v0", "rher/CuePush-v0", "rher/TStack-v0"])
@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_go_on_bitwise(name, duplicate):
    env = gymnasium.make(name)
    env.reset(seed=5)
    play(env, 12)
    other = duplicate(env)
    assert np.array_equal(play(env, 5, seed=1), play(other, 5, seed=1))
    # The next episode follows from the same seed, too.
    assert np.array_equal(env.reset()[0]["observation"], other.reset()[0]["observation"])


def test_copies_of_what_was_not_reset_or_is_closed_are_so_too(env):
    with pytest.raises(rher.StateError):
        copy.deepcopy(env).step(np.zeros(4))
    env.unwrapped.close()
    with pytest.raises(rher.StateError, match="closed"):
        copy.deepcopy(env).reset(seed=1)


def test_a_state_can_be_returned_to_bitwise(env):
    task = env.unwrapped
    task.reset(seed=2)
    play(task, 20)
    state = task.get_state()
    there = play(task, 10, seed=1)
    for same in (state, pickle.loads(pickle.dumps(state)), copy.deepcopy(state)):
        task.reset(seed=9)
        observation, _ = task.set_state(same)
        assert np.array_equal(play(task, 10, seed=1), there)
    assert not np.array_equal(observation["observation"], there[0])


def test_a_state_of_another_task_or_other_options_is_refused(env):
    other = gymnasium.make("rher/PickAndPlace-v0").unwrapped
    slippery = gymnasium.make("rher/Push-v0", randomize={"friction": (0.5, 0.6)}).unwrapped
    env.reset(seed=0)
    for task in (other, slippery):
        task.reset(seed=0)
        with pytest.raises(rher.InputError, match="expected one of"):
            env.unwrapped.set_state(task.get_state())


def test_options_reach_the_simulation():
    plain = gymnasium.make("rher/Push-v0")
    late = gymnasium.make("rher/Push-v0", randomize={"action_delay": (3, 3)})
    plain.reset(seed=0), late.reset(seed=0)
    moved = [abs(e.step([1, 0, 0, 0])[0]["observation"][20]) for e in (plain, late)]
    assert moved[0] > 1e-3 > moved[1]


@pytest.mark.parametrize("name", rher.IDS)
def test_pictures_show_what_happens(name):
    env = gymnasium.make(name, render_mode="rgb_array", width=120, height=90)
    with pytest.raises(rher.StateError, match="nothing to see"):
        env.unwrapped.render()
    env.reset(seed=0)
    first = env.render()
    assert first.shape == (90, 120, 3) and first.dtype == np.uint8
    assert len(np.unique(first.reshape(-1, 3), axis=0)) > 20
    play(env, 3)
    assert not np.array_equal(env.render(), first)
    assert gymnasium.make(name).unwrapped.render() is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"randomize": {"friction": (0.5, 100)}}, "randomize.friction"),
        ({"randomize": {"gravity": (0, 1)}}, "gravity"),
        ({"options": {"nose": 1}}, "task.nose"),
        ({"options": {"nose": print}}, r"options\['nose'\] is <built-in"),
        ({"randomize": {"friction": (1, np.inf)}}, r"randomize\['friction'\]\[1\] is inf"),
        ({"options": 3}, "options is 3, expected a dictionary"),
        ({"render_mode": "human"}, "render_mode"),
        ({"width": 0}, "width"),
    ],
)
def test_wrong_options_are_named(arguments, message):
    with pytest.raises(rher.InputError, match=message):
        rher.TaskEnv("push", **arguments)


def test_an_unknown_task_is_named_with_the_known_ones():
    with pytest.raises(rher.InputError, match="no task is called `fly`; there are reach, push"):
        rher.TaskEnv("fly")


@pytest.mark.parametrize(
    "action",
    [
        np.zeros(3),
        np.zeros((1, 4)),
        0.0,
        [],
        "left",
        None,
        [0, 0, 0, "x"],
        [0, np.nan, 0, 0],
        np.array([None] * 4),
        {"x": 1},
    ],
    ids=repr,
)
def test_wrong_actions_are_refused_and_move_nothing(env, action):
    env.reset(seed=0)
    before = pickle.dumps(env.unwrapped.get_state())
    with pytest.raises(rher.InputError) as error:
        env.step(action)
    assert isinstance(error.value, ValueError) and "action" in str(error.value)
    assert pickle.dumps(env.unwrapped.get_state()) == before


@pytest.mark.parametrize("dtype", [np.float64, np.float16, np.int64, np.int8, bool])
def test_numbers_of_any_type_are_actions(env, dtype):
    env.reset(seed=0)
    expected = env.step(np.array([1, 0, 1, 0], np.float32))[0]["observation"]
    env.reset(seed=0)
    assert np.array_equal(env.step(np.array([1, 0, 1, 0], dtype))[0]["observation"], expected)
    env.reset(seed=0)
    strided = np.array([1, 9, 0, 9, 1, 9, 0, 9], np.float32)[::2]
    assert np.array_equal(env.step(strided)[0]["observation"], expected)


def test_large_actions_are_clipped(env):
    env.reset(seed=0)
    expected = env.step(np.array([1, 0, -1, 0], np.float32))[0]["observation"]
    env.reset(seed=0)
    assert np.array_equal(env.step([7.0, 0.0, -np.inf, 0.0])[0]["observation"], expected)


def test_observations_are_arrays_of_their_own(env):
    first, _ = env.reset(seed=0)
    kept = first["observation"].copy()
    first["achieved_goal"][:] = 7
    second = env.step(np.ones(4, np.float32))[0]
    assert np.array_equal(first["observation"], kept)
    assert not np.shares_memory(first["observation"], second["observation"])
    assert second["achieved_goal"].max() < 7


@pytest.mark.parametrize("seed", [-1, 2**64, 1.5, "1", True])
def test_wrong_seeds_are_refused(env, seed):
    with pytest.raises(rher.InputError, match="seed"):
        env.reset(seed=seed)


def test_steps_before_the_first_reset_and_after_the_end_are_refused(env):
    with pytest.raises(rher.StateError, match="reset the environment") as error:
        env.step(np.zeros(4))
    assert isinstance(error.value, (RuntimeError, gymnasium.error.ResetNeeded))
    with pytest.raises(rher.StateError, match="reset"):
        env.unwrapped.get_state()
    env.reset(seed=0)
    env.close()
    env.close()
    for use in (lambda: env.step(np.zeros(4)), env.reset, env.unwrapped.get_state):
        with pytest.raises(rher.StateError, match="closed"):
            use()


def test_wrong_goals_are_refused(env):
    task = env.unwrapped
    for achieved, desired in [
        (np.zeros(4), np.zeros(4)),
        (np.zeros((2, 3)), np.zeros(3)),
        (0.0, 0.0),
        ("far", "away"),
    ]:
        with pytest.raises(rher.InputError, match="achieved_goal"):
            task.compute_reward(achieved, desired, None)


def test_two_threads_in_one_environment_are_told(env):
    """Each step is whole or refused; nothing else can happen."""
    env.reset(seed=0)
    refused, broken = [], []

    def step_often():
        for _ in range(3000):
            try:
                env.unwrapped.step(np.ones(4, np.float32))
            except rher.StateError as error:
                refused.append(str(error))
            except BaseException as error:  # noqa: BLE001
                broken.append(error)

    threads = [threading.Thread(target=step_often) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not broken
    assert all("another thread" in message for message in refused)


def test_every_exception_is_a_rher_error():
    for name in rher.errors.__all__:
        assert issubclass(getattr(rher.errors, name), rher.RherError)
