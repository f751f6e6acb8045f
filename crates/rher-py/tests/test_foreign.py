"""The agent on environments written by someone else, in Python."""

import os
import signal
import threading

import gymnasium
import numpy as np
import pytest
import rher
from toy import STEPS, Carry


def trainer(env, tiny, out, **arguments):
    arguments = {"set": tiny, "out": out, "episode_steps": STEPS} | arguments
    return rher.Trainer(env, **arguments)


@pytest.mark.parametrize("objects", [0, 1, 2, 3])
def test_it_runs_with_as_many_objects_as_there_are(objects, tiny, out):
    env = Carry(objects)
    run = trainer(env, tiny, out, objects=objects).learn(env_steps=10 * STEPS)
    assert run.metrics["success"].shape == (2, max(2 * objects, 1))
    seen, _ = env.reset(seed=0)
    action = run.policy(seen)
    assert action.shape == (2,)
    # Where the objects are was found in the observation.
    assert np.array_equal(run.policy(seen["observation"], seen["desired_goal"]), action)


def test_it_learns(tiny, out):
    sizes = {
        "agent.hidden": [64, 64],
        "evaluation.every_episodes": 50,
        "evaluation.episodes": 50,
    }
    env = Carry(1)
    fresh = trainer(env, {}, out, set=sizes, workers=1)
    run = fresh.learn(env_steps=15_000, until=0.8)
    assert run.metrics["success_final"].max() >= 0.8
    # The policy does it from Python, too.
    ends = []
    for seed in range(20):
        seen, _ = env.reset(seed=1000 + seed)
        for _ in range(STEPS):
            seen, *_ = env.step(fresh.policy(seen))
        ends.append(np.linalg.norm(seen["achieved_goal"] - seen["desired_goal"]) <= 0.1)
    assert np.mean(ends) >= 0.6


def test_a_run_goes_on_as_if_it_had_not_stopped(tiny, tmp_path):
    whole = trainer(Carry(1), tiny, tmp_path / "whole").learn(env_steps=20 * STEPS)
    trainer(Carry(1), tiny, tmp_path / "parts").learn(env_steps=10 * STEPS)
    resumed = rher.Trainer(Carry(1), episode_steps=STEPS, resume=tmp_path / "parts")
    assert resumed.env_steps == 10 * STEPS
    parts = resumed.learn(env_steps=20 * STEPS)
    for key in ("success_final", "critic_loss", "final_distance"):
        assert np.array_equal(parts.metrics[key], whole.metrics[key]), key
    with pytest.raises(rher.FileError, match="a trainer that was not closed"):
        rher.resume(tmp_path / "parts")
    resumed.close()
    with pytest.raises(rher.StateError, match="closed"):
        resumed.learn()
    with pytest.raises(rher.InputError, match="your own environment"):
        rher.resume(tmp_path / "parts")


def test_a_run_starts_from_one_with_the_same_dimensions(tiny, tmp_path):
    first = trainer(Carry(1), tiny, tmp_path / "first").learn(env_steps=10 * STEPS)
    second = trainer(Carry(1), tiny, tmp_path / "second", from_run=first.path)
    assert second.run.settings["from"]["updates"] == first.metrics["updates"][-1]
    with pytest.raises(rher.SettingsError, match="nothing says which inputs are the same"):
        trainer(Carry(2), tiny, tmp_path / "third", objects=2, from_run=first.path)
    assert not (tmp_path / "third").exists()


class Trouble(Carry):
    """Does something wrong in an episode.

    The first two are those in which the objects are looked for; after five of training there are
    seven of evaluation.
    """

    def __init__(self, what, when):
        super().__init__(1)
        self.what, self.when, self.episodes, self.healthy = what, when, 0, False

    def reset(self, **arguments):
        self.episodes += 1
        return super().reset(**arguments)

    def step(self, action):
        seen, reward, terminated, truncated, info = super().step(action)
        if self.episodes == self.when and self.steps == 7 and not self.healthy:
            seen, terminated = self.what(seen)
        return seen, reward, terminated, truncated, info


def fall_over(seen):
    raise ValueError("the robot fell over")


def lose_track(seen):
    return seen | {"observation": seen["observation"] * np.nan}, False


@pytest.mark.parametrize(
    ("what", "message"),
    [
        (fall_over, "the robot fell over"),
        (lose_track, "NaN in observation"),
        (lambda seen: (seen | {"achieved_goal": np.zeros(2)}, False), r"achieved_goal has shape \[2\], expected \[3\]"),
        (lambda seen: ({}, False), "KeyError"),
        (lambda seen: (None, False), "NoneType"),
    ],
)
@pytest.mark.parametrize("when", [16, 11], ids=["training", "evaluation"])
def test_an_environment_that_fails_is_named_and_progress_is_saved(what, message, when, tiny, out):
    env = Trouble(what, when)
    failing = trainer(env, tiny, out)
    with pytest.raises(rher.EnvError, match=message) as error:
        failing.learn(env_steps=10_000)
    assert "progress was saved" in str(error.value)
    if what is fall_over:
        assert type(error.value.__cause__) is ValueError
        assert error.value.__cause__.__traceback__ is not None
    saved = failing.env_steps
    assert saved == {16: 6, 11: 5}[when] * STEPS
    failing.close()
    # The run continues with the episode that failed, once the environment works.
    env.healthy = True
    again = rher.Trainer(env, episode_steps=STEPS, resume=out)
    assert again.env_steps == saved
    assert again.learn(env_steps=saved + 10 * STEPS).metrics["env_steps"][-1] > saved


def test_ctrl_c_saves_and_comes_out(tiny, out):
    running = trainer(Carry(1), tiny, out)
    started = threading.Event()
    timer = threading.Thread(
        target=lambda: started.wait(10) and os.kill(os.getpid(), signal.SIGINT)
    )
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        running.learn(env_steps=10_000_000, on_event=lambda event: started.set())
    timer.join()
    assert running.env_steps > 0
    running.close()
    assert rher.Trainer(Carry(1), episode_steps=STEPS, resume=out).env_steps > 0


def test_a_trainer_that_trains_cannot_be_used_by_another_thread(tiny, out):
    running = trainer(Carry(1), tiny, out)
    errors = []

    def use(event):
        with pytest.raises(rher.StateError, match="is training") as error:
            running.policy  # noqa: B018
        errors.append(error)

    running.learn(env_steps=5 * STEPS, on_event=use)
    assert errors


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"objects": 2}, r"goals have \[3, 3\] numbers, expected 6"),
        ({"objects": 4}, "objects is 4"),
        ({"gripper": slice(0, 4)}, "gripper"),
        ({"gripper": slice(5, 8)}, "gripper"),
        ({"episode_steps": 2**30}, "episode_steps"),
        ({"gripper": 3}, r"gripper is 3, expected a slice such as slice\(0, 3\)"),
        ({"tolerance": -1.0}, "tolerance"),
        ({"set": {"randomize.friction": [1, 2]}}, "randomize.friction"),
        ({"set": {"envs": 2}}, "envs"),
        ({"preset": "slow"}, "slow"),
    ],
)
def test_wrong_arguments_are_named(arguments, message, tiny, out):
    with pytest.raises(rher.RherError, match=message):
        trainer(Carry(1), tiny, out, **arguments)


def test_environments_that_cannot_be_learned_are_told(tiny, out):
    with pytest.raises(rher.InputError, match="expected a Dict"):
        trainer(gymnasium.make("Pendulum-v1"), tiny, out)
    spaces = [
        (gymnasium.spaces.Box(-np.inf, np.inf, (2,)), "finite limits: .*TransformAction"),
        (gymnasium.spaces.Box(-1, 1, (2,), np.int64), "one of float32 or float64"),
        (gymnasium.spaces.Box(-1, 1, (2, 1)), "one-dimensional Box"),
        (gymnasium.spaces.Discrete(2), "one-dimensional Box"),
    ]
    for space, message in spaces:
        env = Carry(1)
        env.action_space = space
        with pytest.raises(rher.InputError, match=message):
            trainer(env, tiny, out)


@pytest.mark.parametrize("preset", ["paper", "fast"])
@pytest.mark.parametrize(
    ("name", "objects"), [("FetchReach-v4", 0), ("FetchPush-v4", 1), ("FetchPickAndPlace-v4", 1)]
)
def test_it_runs_on_fetch(name, objects, preset, tiny, out):
    robotics = pytest.importorskip("gymnasium_robotics")
    gymnasium.register_envs(robotics)
    run = rher.Trainer(
        gymnasium.make(name), objects=objects, preset=preset, set=tiny, out=out
    ).learn(env_steps=250)
    assert list(run.metrics["env_steps"]) == [250]
    assert run.settings["task"]["name"] == name
    if objects:
        # The block is where it is in our own tasks.
        ours, _ = gymnasium.make("rher/Push-v0").reset(seed=0)
        assert run.policy(ours["observation"], ours["desired_goal"]).shape == (4,)
