"""Episodes that begin as `reset(options=...)` says."""

import copy
import pickle

import gymnasium
import numpy as np
import pytest
import rher

GOAL = [1.2, 0.8, 0.42469]
LAYOUT = [1.4, 0.65, 0.42469]


def play(env, steps, seed=0):
    rng = np.random.default_rng(seed)
    actions = rng.uniform(-1, 1, (steps, *env.action_space.shape)).astype(np.float32)
    return [env.step(action)[0]["observation"] for action in actions]


def test_goal_layout_and_turns_are_what_was_chosen():
    env = gymnasium.make("rher/Push-v0")
    plain, _ = env.reset(seed=3)
    seen, _ = env.reset(seed=3, options={"goal": GOAL})
    assert np.allclose(seen["desired_goal"], GOAL, atol=1e-6)
    assert np.array_equal(seen["observation"], plain["observation"]), "the rest is that of the seed"

    seen, _ = env.reset(seed=3, options={"layout": np.array(LAYOUT, np.float32), "turns": [0.5]})
    assert np.allclose(seen["achieved_goal"], LAYOUT, atol=1e-3)
    assert np.array_equal(seen["desired_goal"], plain["desired_goal"])
    assert seen["observation"][13] == pytest.approx(0.5, abs=1e-3), "the angle about z"

    # The next episodes are drawn as if nothing had been chosen.
    env.reset(seed=3)
    expected, _ = env.reset()
    env.reset(seed=3, options={"goal": GOAL, "layout": LAYOUT})
    assert np.array_equal(env.reset()[0]["desired_goal"], expected["desired_goal"])
    assert np.array_equal(env.reset(options={})[0].keys(), expected.keys())


def test_an_object_at_its_goal_is_a_success():
    env = gymnasium.make("rher/DPush-v0")
    places = [*GOAL, *LAYOUT]
    _, info = env.reset(seed=0, options={"goal": places, "layout": places})
    assert info["is_success"] == 1.0
    assert env.step(np.zeros(4, np.float32))[1] == 0.0


@pytest.mark.parametrize("name", rher.IDS)
def test_every_task_takes_a_goal(name):
    env = gymnasium.make(name)
    goal = env.reset(seed=5)[0]["desired_goal"]
    seen, _ = env.reset(seed=0, options={"goal": goal})
    assert np.array_equal(seen["desired_goal"], goal)
    assert env.observation_space.contains(env.step(env.action_space.sample())[0])


@pytest.mark.parametrize("name", set(rher.IDS) - {"rher/Reach-v0", "rher/Insert-v0"})
def test_tasks_with_objects_take_a_layout(name):
    env = gymnasium.make(name)
    layout = env.reset(seed=5)[0]["achieved_goal"]
    seen, _ = env.reset(seed=0, options={"layout": layout})
    assert np.allclose(seen["achieved_goal"], layout, atol=0.01), "but for noise"


def test_states_and_copies_remember_how_an_episode_began():
    env = gymnasium.make("rher/Push-v0").unwrapped
    env.reset(seed=3, options={"goal": GOAL, "layout": LAYOUT})
    play(env, 4)
    state = env.get_state()
    twins = [copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    expected = play(env, 5, seed=1)
    for twin in twins:
        assert np.array_equal(play(twin, 5, seed=1), expected)
    env.reset(seed=9)
    seen, _ = env.set_state(pickle.loads(pickle.dumps(state)))
    assert np.allclose(seen["desired_goal"], GOAL, atol=1e-6)
    assert np.array_equal(play(env, 5, seed=1), expected)


def test_rows_of_a_vector_are_its_environments_alone():
    envs = gymnasium.make_vec("rher/Push-v0", num_envs=3)
    goals = np.tile(GOAL, (3, 1)) + 0.01 * np.arange(3)[:, None]
    seen, _ = envs.reset(seed=5, options={"goal": goals, "layout": LAYOUT})
    for row in range(3):
        one = gymnasium.make("rher/Push-v0")
        alone, _ = one.reset(seed=5 + row, options={"goal": goals[row], "layout": LAYOUT})
        for key in alone:
            assert np.array_equal(seen[key][row], alone[key])
    state = envs.get_state()
    expected = play(envs, 3)
    again = gymnasium.make_vec("rher/Push-v0", num_envs=3)
    again.set_state(state)
    assert np.array_equal(play(again, 3), expected)
    assert np.array_equal(play(pickle.loads(pickle.dumps(again)), 2), play(again, 2))


def test_a_mask_and_a_goal_go_together():
    envs = gymnasium.make_vec("rher/Push-v0", num_envs=2, autoreset_mode="Disabled")
    before, _ = envs.reset(seed=0)
    mask = np.array([False, True])
    after, _ = envs.reset(options={"reset_mask": mask, "goal": GOAL})
    assert np.array_equal(after["desired_goal"][0], before["desired_goal"][0])
    assert np.allclose(after["desired_goal"][1], GOAL, atol=1e-6)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (3, "options is 3, expected a dictionary"),
        ({"goals": GOAL}, "reset has no option 'goals', expected layout, turns, goal"),
        ({"goal": GOAL[:2]}, r"options\['goal'\] has shape \(2,\), expected \(3,\)"),
        ({"goal": [GOAL]}, r"options\['goal'\] has shape \(1, 3\), expected \(3,\)"),
        ({"goal": [1, 2, np.nan]}, r"options\['goal'\] has the number nan, expected -100"),
        ({"goal": [1, 2, 1e9]}, r"options\['goal'\] has the number 1000000000.0, expected -100"),
        ({"goal": "there"}, r"options\['goal'\] is 'there', expected numbers of shape \(3,\)"),
        ({"layout": [None] * 3}, r"options\['layout'\] is \[None, None, None\], expected numbers"),
        ({"layout": [[1], [2, 3]]}, r"options\['layout'\] is .*, expected numbers"),
        ({"turns": LAYOUT}, r"options\['turns'\] has shape \(3,\), expected \(1,\)"),
    ],
)
def test_wrong_options_are_named(options, message):
    env = gymnasium.make("rher/Push-v0").unwrapped
    envs = gymnasium.make_vec("rher/Push-v0", num_envs=2)
    env.reset(seed=0)
    before = pickle.dumps(env.get_state())
    with pytest.raises(rher.InputError, match=message):
        env.reset(options=options)
    assert pickle.dumps(env.get_state()) == before, "nothing has changed"
    with pytest.raises(rher.InputError, match=message.split(",")[0]):
        envs.reset(seed=0, options=options)


def test_a_layout_that_a_task_does_not_have_is_refused():
    for name in ("rher/Reach-v0", "rher/Insert-v0", "rher/Drawer-v0"):
        env = gymnasium.make(name)
        with pytest.raises(rher.InputError, match="object 1 cannot start at .*: this task puts it at"):
            env.reset(seed=0, options={"layout": [1.0, 0.3, 0.9]})
        with pytest.raises(rher.StateError, match="reset"):
            env.step(env.action_space.sample())
        env.reset(seed=0)
    envs = gymnasium.make_vec("rher/Reach-v0", num_envs=2)
    with pytest.raises(rher.InputError, match="environment 0 failed: object 1 cannot start"):
        envs.reset(seed=0, options={"layout": LAYOUT})


def test_objects_in_one_another_stay_finite():
    env = gymnasium.make("rher/DPush-v0")
    env.reset(seed=0, options={"layout": [*LAYOUT, *LAYOUT]})
    assert np.isfinite(play(env, 20)).all()
