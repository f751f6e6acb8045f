"""Several environments side by side, in processes of their own or here, and calls that hang."""

import functools
import os
import time

import gymnasium
import numpy as np
import pytest
import rher
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv
from toy import STEPS, Carry, Ending, Flat

KEYS = ("success_final", "critic_loss", "final_distance", "env_steps")


def trainer(env, tiny, out, **arguments):
    return rher.Trainer(env, **({"set": tiny, "out": out, "episode_steps": STEPS} | arguments))


def test_several_are_the_same_run_however_they_are_given(tiny, tmp_path):
    makes = [functools.partial(Ending, 1)] * 2
    given = {
        "functions": makes,
        "sync": SyncVectorEnv(makes),
        "async": AsyncVectorEnv(makes, shared_memory=False),
        "again": makes,
    }
    runs = {}
    for name, envs in given.items():
        with trainer(envs, tiny, tmp_path / name, workers=2) as one:
            runs[name] = one.learn(env_steps=20 * STEPS)
            assert one.run.settings["envs"] == 2
    given["async"].close()
    for name, run in runs.items():
        for key in KEYS:
            assert np.array_equal(run.metrics[key], runs["functions"].metrics[key]), (name, key)
    assert len(runs["sync"].metrics["env_steps"]) > 2


def test_a_registered_environment_is_made_once_more(tiny, out):
    envs = gymnasium.make_vec("rher/Push-v0", num_envs=2)
    with rher.Trainer(envs, set=tiny, out=out) as push:
        assert push.learn(env_steps=100).metrics["env_steps"].tolist() == [100]
    assert push.run.settings["task"]["name"] == "rher-Push-v0"


def test_a_run_of_several_is_resumed_with_as_many(tiny, out):
    makes = [functools.partial(Carry, 1)] * 2
    with trainer(makes, tiny, out) as first:
        first.learn(env_steps=10 * STEPS)
    with pytest.raises(rher.SettingsError, match="1 environments were given, expected at least"):
        rher.Trainer(Carry(1), episode_steps=STEPS, resume=out)
    with rher.Trainer(makes, episode_steps=STEPS, resume=out) as again:
        assert again.learn(env_steps=20 * STEPS).metrics["env_steps"][-1] == 20 * STEPS


def test_processes_end_with_the_trainer(tiny, out):
    class Named(Carry):
        def seen(self):
            return super().seen() | {"observation": np.full(6, os.getpid() % 1000)}

    with trainer([functools.partial(Named, 1)] * 2, tiny, out) as one:
        processes = [process for env in one._given.envs for process in env._envs.processes]
        assert all(process.is_alive() for process in processes) and len(processes) == 2
    assert not any(process.is_alive() for process in processes)


@pytest.mark.parametrize(
    ("envs", "message"),
    [
        ([], "env is .*, expected an environment of Gymnasium, a vector environment, or a list"),
        ([Carry(1)], "a list of functions"),
        ("FetchPush-v4", "expected an environment"),
        ([lambda: 3], "the first function made 3"),
        ([functools.partial(Carry, 1), lambda: Flat(Carry(1))], "the environments differ"),
        (
            gymnasium.wrappers.vector.RecordEpisodeStatistics(SyncVectorEnv([Carry])),
            "with its wrappers",
        ),
    ],
)
def test_what_are_no_environments_is_refused(envs, message, tiny, out):
    with pytest.raises(rher.InputError, match=message):
        trainer(envs, tiny, out)


class Stuck(Carry):
    """Does something wrong in the seventh step of its third episode, once there is a file."""

    def __init__(self, what, marker):
        super().__init__(1)
        self.what, self.marker, self.episodes = what, marker, 0

    def reset(self, **arguments):
        self.episodes += 1
        return super().reset(**arguments)

    def step(self, action):
        seen, *rest = super().step(action)
        if self.episodes >= 6 and self.steps == 7 and self.marker.exists():
            if self.what == "hang":
                time.sleep(600)
            elif self.what == "raise":
                raise ValueError("the robot fell over")
            elif self.what == "die":
                os._exit(1)
            elif self.what == "narrow":
                seen = seen | {"achieved_goal": np.zeros(1)}
            else:
                seen = seen | {"observation": seen["observation"] * np.nan}
        return seen, *rest


@pytest.mark.parametrize("where", ["here", "process"])
@pytest.mark.parametrize(
    ("what", "message"),
    [
        ("hang", "TimeoutError: `step` took longer than step_timeout=0.5 seconds"),
        ("raise", "the robot fell over"),
        ("nan", "NaN in observation"),
        ("narrow", "expected|shape"),
        ("die", "the process of the environment has ended"),
    ],
)
def test_what_goes_wrong_loses_at_most_the_running_episode(what, message, where, tiny, tmp_path):
    if (what, where) == ("die", "here"):
        pytest.skip("that would end the test, too")
    marker, out = tmp_path / "marker", tmp_path / "run"
    marker.touch()
    make = functools.partial(Stuck, what, marker)
    given = make() if where == "here" else [make]
    failing = trainer(given, tiny, out, step_timeout=0.5)
    with pytest.raises(rher.EnvError, match=message) as error:
        failing.learn(env_steps=10_000)
    assert "progress was saved" in str(error.value)
    saved = failing.env_steps
    assert saved >= STEPS
    failing.close()
    marker.unlink()
    given = make() if where == "here" else [make]
    with rher.Trainer(given, episode_steps=STEPS, resume=out, step_timeout=5) as again:
        assert again.env_steps == saved
        assert again.learn(env_steps=saved + 3 * STEPS).metrics["env_steps"][-1] > saved


def test_an_environment_that_is_stuck_is_not_called_again(tiny, tmp_path):
    marker = tmp_path / "marker"
    marker.touch()
    failing = trainer(Stuck("hang", marker), tiny, tmp_path / "run", step_timeout=0.3)
    with pytest.raises(rher.EnvError, match="took longer"):
        failing.learn(env_steps=10_000)
    with pytest.raises(rher.EnvError, match="stuck in an earlier call: make it anew"):
        failing.learn(env_steps=10_000)
    for timeout in (0, -1, "long", float("nan")):
        with pytest.raises(rher.InputError, match="step_timeout is"):
            trainer(Carry(1), tiny, tmp_path / "other", step_timeout=timeout)
