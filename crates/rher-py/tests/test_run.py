"""What is done with a run that is there."""

import importlib
import json
import sys

import numpy as np
import pytest
import rher
from toy import Carry


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    from conftest import TINY

    out = tmp_path_factory.mktemp("runs") / "push"
    return rher.train("push", set=TINY, env_steps=500, until=0, out=out)


def test_a_policy_is_evaluated(run):
    report = run.evaluate(episodes=10, workers=1)
    assert report["task"] == "push" and report["episodes"] == 10 and report["held_out"]
    low, high = report["ci95"]
    assert low <= report["success_final"] <= high and len(report["success"]) == 2
    assert run.evaluate(episodes=10, seed=0)["held_out"] is False


def test_a_policy_is_evaluated_in_other_environments(run):
    large = {"randomize.size": np.array([1.1, 1.2])}
    plain, other = run.evaluate(episodes=5), run.evaluate(episodes=5, set=large)
    assert plain["final_distance"] != other["final_distance"]
    with pytest.raises(rher.RherError, match="agent.discount"):
        run.evaluate(set={"agent.discount": 0.9})


def test_episodes_are_drawn_and_recorded(run, tmp_path):
    film = run.play(tmp_path / "push.gif", episodes=1)
    assert film.read_bytes().startswith(b"GIF8")
    assert run.play(tmp_path / "push.mcap").read_bytes().startswith(b"\x89MCAP")
    small = run.play(tmp_path / "small.gif", camera="top", size=(96, 72), trim=True)
    assert 0 < small.stat().st_size < film.stat().st_size
    with pytest.raises(rher.InputError, match="out is `push.txt`, expected a name that ends in"):
        run.play("push.txt")
    with pytest.raises(rher.InputError, match="camera"):
        run.play(tmp_path / "push.gif", camera="moon")


def test_curves_are_drawn(run, tmp_path):
    curves = run.plot(tmp_path / "curves.svg")
    assert "<svg" in curves.read_text()
    assert run.plot(tmp_path / "curves.png", x="time").read_bytes().startswith(b"\x89PNG")
    titled = run.plot(tmp_path / "curves.svg", run, title="Three seeds", measure="iqm", subtasks=False)
    assert "Three seeds" in titled.read_text()
    with pytest.raises(rher.InputError, match="hours"):
        run.plot(tmp_path / "curves.svg", x="hours")
    with pytest.raises(rher.RherError, match="curves"):
        run.plot(tmp_path / "no" / "curves.svg")


def test_metrics_are_a_table_of_pandas(run):
    pytest.importorskip("pandas")
    table = run.to_pandas()
    assert list(table["env_steps"]) == [250, 500]
    metrics = run.metrics
    assert np.array_equal(table[["success.1", "success.2"]], metrics["success"])
    assert np.array_equal(table["time.update"], metrics["time.update"])


def test_without_pandas_it_says_what_to_install(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(rher.MissingError, match=r"pip install 'rher\[pandas\]'") as error:
        run.to_pandas()
    assert isinstance(error.value, (rher.RherError, ImportError))


def test_without_sb3_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "stable_baselines3.common.vec_env", None)
    monkeypatch.delitem(sys.modules, "rher.sb3", raising=False)
    with pytest.raises(rher.MissingError, match=r"pip install 'rher\[sb3\]'"):
        importlib.import_module("rher.sb3")


def test_a_run_on_an_environment_of_ones_own_says_what_to_do(tiny, out):
    with rher.Trainer(Carry(), set=tiny, episode_steps=25, out=out, name="carry") as trainer:
        trainer.learn(env_steps=125)
        assert trainer.run.state == "running"
    run = rher.Run(out)
    assert run.state == "spent" or run.state == "stopped"
    assert run.plot(out / "curves.svg").exists()
    for use in (run.evaluate, lambda: run.play("carry.gif")):
        with pytest.raises(rher.InputError, match="an environment of your own, `carry`"):
            use()


def test_the_state_of_a_run_says_whether_it_goes_on(run, tiny, out):
    assert run.state == "spent"
    stopped = rher.train("push", set=tiny, env_steps=10**7, until=0, out=out, max_wall=0.5)
    assert stopped.state == "stopped"
    steps = int(stopped.metrics["env_steps"][-1])
    assert rher.resume(out, env_steps=steps + 250).state == "spent"


def test_a_run_writes_recordings_and_event_files(tiny, out):
    run = rher.train(
        "push", set=tiny, env_steps=500, out=out, until=0, record_every=5, tensorboard=True
    )
    (recording,) = out.glob("*.mcap")
    assert recording.name == "episodes-0.mcap"
    assert recording.read_bytes().startswith(b"\x89MCAP")
    assert len(list((out / "tensorboard").iterdir())) == 1
    rher.resume(out, env_steps=1000, record_every=5, tensorboard=True)
    assert {path.name for path in out.glob("*.mcap")} == {"episodes-0.mcap", "episodes-10.mcap"}
    assert len(list((out / "tensorboard").iterdir())) == 2
    assert run.metrics["env_steps"][-1] == 1000


def test_recordings_of_environments_of_ones_own_are_refused(tiny, out):
    with rher.Trainer(Carry(), set=tiny, episode_steps=25, out=out) as trainer:
        with pytest.raises(TypeError, match="record_every"):
            trainer.learn(env_steps=125, record_every=1)


def test_settings_of_the_command_line_are_arguments(tiny, out):
    run = rher.train("rher/Push-v0", set=tiny, env_steps=250, out=out, precision="f32", envs=2)
    agent = run.settings["agent"]
    assert agent["precision"] == "f32" and run.settings["envs"] == 2
    run = rher.resume(out, env_steps=500, engine="burn")
    with pytest.raises(rher.SettingsError, match="f16"):
        rher.resume(out, env_steps=750, precision="f16")
    with pytest.raises(rher.SettingsError, match="gpu"):
        rher.train("push", engine="gpu", out=out.with_name("other"))
    assert json.dumps(run.settings)
