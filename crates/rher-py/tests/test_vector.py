"""Environments stepped together: rows, autoreset modes, and what is refused."""

import copy
import pickle
import threading
import warnings

import gymnasium
import numpy as np
import pytest
import rher
from gymnasium.vector import AutoresetMode, SyncVectorEnv

STEPS = 120


def together(mode=AutoresetMode.NEXT_STEP, envs=3, name="rher/Push-v0", **arguments):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return gymnasium.make_vec(name, num_envs=envs, autoreset_mode=mode, **arguments)


def reference(mode, envs=3, name="rher/Push-v0"):
    """What Gymnasium makes of as many single environments."""
    return SyncVectorEnv([lambda: gymnasium.make(name)] * envs, autoreset_mode=mode)


def actions(envs, steps, width=4):
    return np.random.default_rng(0).uniform(-1, 1, (steps, envs, width)).astype(np.float32)


def assert_same(one, other, path=""):
    """Equal to the last bit, types included."""
    assert type(one) is type(other), path
    if isinstance(one, dict):
        assert one.keys() == other.keys(), path
        for key in one:
            assert_same(one[key], other[key], f"{path}.{key}")
    elif isinstance(one, tuple):
        assert len(one) == len(other), path
        for index, pair in enumerate(zip(one, other)):
            assert_same(*pair, f"{path}[{index}]")
    elif isinstance(one, np.ndarray) and one.dtype == object:
        for index, pair in enumerate(zip(one, other)):
            assert_same(*pair, f"{path}[{index}]")
    elif one is not None:
        assert one.dtype == other.dtype and np.array_equal(one, other), path


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize("name", ["rher/Push-v0", "rher/CuePush-v0"])
def test_it_is_what_gymnasium_makes_of_single_environments(mode, name):
    ours, theirs = together(mode, name=name), reference(mode, name=name)
    assert ours.metadata["autoreset_mode"] is mode
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    assert_same(ours.reset(seed=4), theirs.reset(seed=4))
    ends = 0
    for step, action in enumerate(actions(3, STEPS, ours.single_action_space.shape[0])):
        one, other = ours.step(action), theirs.step(action)
        assert_same(one, other, f"step {step}")
        ends += one[3].sum()
    assert ends >= 6


def test_disabled_autoreset_waits_for_a_mask():
    ours, theirs = together(AutoresetMode.DISABLED), reference(AutoresetMode.DISABLED)
    assert_same(ours.reset(seed=4), theirs.reset(seed=4))
    for action in actions(3, 50):
        assert_same(ours.step(action), theirs.step(action))
    with pytest.raises(rher.StateError, match="environment 0 has to be reset"):
        ours.step(action)
    mask = np.array([True, False, True])
    first = ours.reset(options={"reset_mask": mask})
    assert_same(first, theirs.reset(options={"reset_mask": mask}))
    with pytest.raises(rher.StateError, match="environment 1 has to be reset"):
        ours.step(action)
    assert_same(*(e.reset(options={"reset_mask": ~mask}) for e in (ours, theirs)))
    assert_same(ours.step(action), theirs.step(action))


def test_the_number_of_threads_changes_nothing():
    one, many = together(envs=7, threads=1), together(envs=7, threads=5)
    assert_same(one.reset(seed=0), many.reset(seed=0))
    for action in actions(7, STEPS):
        assert_same(one.step(action), many.step(action))


def test_arrays_are_new_ones_unless_asked_otherwise():
    envs = together()
    first = envs.reset(seed=0)[0]
    second = envs.step(actions(3, 1)[0])
    assert not np.shares_memory(first["observation"], second[0]["observation"])
    envs = together(copy=False)
    first = envs.reset(seed=0)[0]
    second, rewards = envs.step(actions(3, 1)[0])[:2]
    assert np.shares_memory(first["observation"], second["observation"])
    assert np.shares_memory(rewards, envs.step(actions(3, 1)[0])[1])


def test_seeds_are_one_for_each_row_or_counted_from_one():
    envs = together()
    counted = envs.reset(seed=5)[0]["observation"]
    assert np.array_equal(envs.reset(seed=[5, 6, 7])[0]["observation"], counted)
    following = envs.reset()[0]["observation"]
    assert not np.array_equal(following, counted)
    envs.reset(seed=5)
    assert np.array_equal(envs.reset()[0]["observation"], following)
    assert not np.array_equal(*(together().reset()[0]["observation"] for _ in "ab"))


def test_rewards_of_goals_can_be_computed():
    envs = together(envs=2)
    assert list(envs.compute_reward(np.zeros((2, 3)), np.eye(2, 3), None)) == [-1, -1]


MODES = [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP, AutoresetMode.DISABLED]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("steps", [0, 3, 7, 8, 12])
def test_copies_and_states_go_on_bitwise(mode, steps):
    """Seven steps are an episode: some of these moments are between two."""
    envs = together(mode, max_episode_steps=7, randomize={"friction": (0.5, 1.5)})
    envs.reset(seed=[5, 6, 2**64 - 1])
    drawn = actions(3, 30)
    everyone = {"reset_mask": np.ones(3, bool)}

    def play(envs, actions):
        results = []
        for action in actions:
            results.append(envs.step(action))
            if mode is AutoresetMode.DISABLED and results[-1][3].all():
                results.append(envs.reset(options=everyone))
        return results

    play(envs, drawn[:steps])
    state = envs.get_state()
    twins = [copy.deepcopy(envs), pickle.loads(pickle.dumps(envs))]
    expected = play(envs, drawn[steps:])
    for twin in twins:
        assert twin.num_envs == 3 and twin.autoreset_mode is mode
        assert_same(tuple(play(twin, drawn[steps:])), tuple(expected))
    fresh = together(mode, max_episode_steps=7, randomize={"friction": (0.5, 1.5)})
    for other in (envs, fresh):
        other.set_state(state)
        assert_same(tuple(play(other, drawn[steps:])), tuple(expected))
    assert_same(fresh.reset(), envs.reset())


def test_copies_before_the_first_reset_and_after_the_end():
    envs = together()
    twin = copy.deepcopy(envs)
    with pytest.raises(rher.StateError, match="has to be reset"):
        twin.step(np.zeros((3, 4)))
    assert_same(twin.reset(seed=1), envs.reset(seed=1))
    envs.close()
    with pytest.raises(rher.StateError, match="closed"):
        pickle.loads(pickle.dumps(envs)).step(np.zeros((3, 4)))


@pytest.mark.parametrize(
    ("state", "message"),
    [
        (3, "state is 3, expected what get_state returned"),
        (b"junk", "expected what get_state returned"),
        (lambda: together(envs=2), "records of environments: 2 numbers, expected 3 for 3 environments"),
        (lambda: together(name="rher/DPush-v0"), "recorded observations"),
    ],
)
def test_states_of_others_are_refused(state, message):
    if callable(state):
        other = state()
        other.reset(seed=0)
        state = other.get_state()
    envs = together()
    envs.reset(seed=0)
    with pytest.raises(rher.InputError, match=message):
        envs.set_state(state)


@pytest.mark.parametrize("steps", [1, 7, 60])
def test_the_length_of_episodes_can_be_chosen(steps):
    mode = AutoresetMode.NEXT_STEP
    ours = together(mode, max_episode_steps=steps)
    make = lambda: gymnasium.make("rher/Push-v0", max_episode_steps=steps)  # noqa: E731
    theirs = SyncVectorEnv([make] * 3, autoreset_mode=mode)
    assert_same(ours.reset(seed=4), theirs.reset(seed=4))
    for action in actions(3, 65):
        assert_same(ours.step(action), theirs.step(action))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"envs": 0}, "num_envs is 0"),
        ({"threads": 0}, "threads is 0"),
        ({"render_mode": "human"}, "render_mode is 'human', expected 'rgb_array'"),
        ({"width": 0}, "width is 0"),
        ({"mode": "Whenever"}, "expected NextStep, SameStep, Disabled"),
        ({"max_episode_steps": 0}, "max_episode_steps is 0"),
        ({"randomize": {"mass": 1}}, "options of `push`"),
    ],
)
def test_wrong_arguments_are_named(arguments, message):
    with pytest.raises(rher.InputError, match=message):
        together(**arguments)


@pytest.mark.parametrize("wrong", [np.zeros((3, 3)), np.zeros(4), "left", np.full((3, 4), np.nan)])
def test_wrong_actions_are_refused(wrong):
    envs = together()
    with pytest.raises(rher.StateError, match="environment 0 has to be reset"):
        envs.step(np.zeros((3, 4)))
    envs.reset(seed=0)
    with pytest.raises(rher.InputError, match="actions"):
        envs.step(wrong)


@pytest.mark.parametrize(
    "arguments",
    [
        {"seed": [1, 2]},
        {"seed": -1},
        {"options": {"reset_mask": np.ones(2, bool)}},
        {"options": {"reset_mask": [1, 0, 1]}},
        {"options": {"reset_mask": np.ones(3, bool)}, "seed": 1},
        {"options": {"speed": 1}},
    ],
)
def test_wrong_resets_are_refused(arguments):
    envs = together()
    envs.reset(seed=0)
    with pytest.raises(rher.InputError):
        envs.reset(**arguments)


def test_closed_environments_say_so():
    envs = together()
    envs.reset(seed=0)
    envs.close()
    with pytest.raises(rher.StateError, match="closed"):
        envs.step(np.zeros((3, 4)))


def test_python_runs_while_environments_are_stepped_and_a_second_thread_is_told():
    envs = together(envs=256, threads=1)
    envs.reset(seed=0)
    action = np.zeros((256, 4), np.float32)
    stepping = threading.Thread(target=lambda: [envs.step(action) for _ in range(20)])
    stepping.start()
    refused = 0
    while stepping.is_alive():
        try:
            envs.step(action)
        except rher.StateError as error:
            assert "another thread" in str(error)
            refused += 1
    assert refused > 0
