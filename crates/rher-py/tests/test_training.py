"""Runs on our tasks: what they write, how they stop, and what is refused."""

import json
import os
import signal
import threading

import numpy as np
import pytest
import rher


def timeless(run):
    """Metrics but for the clock's."""
    return {key: v for key, v in run.metrics.items() if not key.startswith(("wall_s", "time."))}


def assert_same(one, other):
    assert one.keys() == other.keys()
    for key in one:
        np.testing.assert_array_equal(one[key], other[key], key)


def test_a_run_tells_what_happens_and_writes_it_down(tiny, out):
    events = []
    run = rher.train("push", seed=3, set=tiny, env_steps=500, out=out, on_event=events.append)
    kinds = [event["kind"] for event in events]
    assert kinds.count("progress") == 10 and kinds.count("evaluated") == 2
    assert kinds[0] == "saved" and kinds[-1] == "saved"
    assert [event["env_steps"] for event in events if event["kind"] == "progress"][-1] == 500

    metrics = run.metrics
    assert list(metrics["env_steps"]) == [250, 500]
    assert metrics["success"].shape == (2, 2) and metrics["time.update"].shape == (2,)
    last = [event for event in events if event["kind"] == "evaluated"][-1]
    assert last["success_final"] == metrics["success_final"][-1]
    assert run.settings["seed"] == 3 and run.settings["agent"]["hidden"] == [16, 16]
    assert run.policy.task == "push"


def test_metrics_that_were_not_measured_are_nan(tiny, out):
    run = rher.train("push", method="her", set=tiny, env_steps=250, out=out)
    assert np.isnan(run.metrics["success"][0, 0]) and not np.isnan(run.metrics["success"][0, 1])


def test_the_same_seed_gives_the_same_run_whatever_the_threads(tiny, tmp_path):
    runs = [
        rher.train("pick", set=tiny, env_steps=500, out=tmp_path / str(workers), workers=workers)
        for workers in (1, 2)
    ]
    assert_same(*map(timeless, runs))


def test_an_interrupted_run_goes_on_as_if_it_had_not_stopped(tiny, tmp_path):
    whole = rher.train("push", set=tiny, env_steps=1000, until=0, out=tmp_path / "whole")
    out = tmp_path / "parts"
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))

    def slow(event):
        if event["kind"] == "progress" and not timer.is_alive() and not timer.finished.is_set():
            timer.start()
        timer.finished.wait(0.05)

    with pytest.raises(KeyboardInterrupt):
        rher.train("push", set=tiny, env_steps=1_000_000, until=0, out=out, on_event=slow)
    steps = json.loads((out / "metrics.jsonl").read_text().splitlines()[-1])["env_steps"]
    wanted = max(1000, steps)
    part = rher.resume(out, env_steps=wanted)
    rows = len(whole.metrics["env_steps"])
    ours = {key: value[:rows] for key, value in timeless(part).items()}
    assert_same(ours, timeless(whole))


def test_an_exception_in_the_callback_comes_out_and_the_run_is_saved(tiny, out):
    def fail(event):
        if event["kind"] == "evaluated":
            raise ZeroDivisionError("plotting failed")

    with pytest.raises(ZeroDivisionError, match="plotting failed"):
        rher.train("push", set=tiny, env_steps=100_000, out=out, on_event=fail)
    assert rher.Run(out).policy.task == "push"
    steps = rher.Run(out).metrics["env_steps"][-1]
    assert rher.resume(out, env_steps=int(steps) + 500).metrics["env_steps"][-1] > steps


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"set": {"agent.discont": 1}}, "no setting `agent.discont`; did you mean `agent.discount`"),
        ({"set": {"agent.discount": 2.0}}, "agent.discount"),
        ({"set": {"agent.discount": "high"}}, "expected a number"),
        ({"set": {"agent.hidden": print}}, r"set\['agent.hidden'\] is <built-in"),
        ({"set": {"randomize.friction": [9, 9]}}, "randomize.friction"),
        ({"set": {"task.noise": 1}}, "of `cue-push`, not of `push`"),
        ({"preset": "slow"}, "slow"),
        ({"method": "ppo"}, "ppo"),
        ({"until": 2}, "until"),
        ({"env_steps": -1}, "-1"),
        ({"env_steps": 0}, "env_steps"),
        ({"env_steps": 1e2}, r"env_steps is 100.0, expected a whole number"),
        ({"seed": 2**63}, r"seed is 9223372036854775808, expected 0 to 2\*\*63 - 1"),
        ({"set": {"agent.discount": np.nan}}, r"set\['agent.discount'\] is nan"),
        ({"set": {3: 4}}, "a key of set is 3"),
        ({"set": 3}, "set is 3, expected a dictionary"),
        ({"task": 3}, "task is 3, expected a string"),
        ({"preset": 3}, "preset is 3, expected a string"),
        ({"config": 3}, "config is 3, expected a path"),
        ({"on_event": 3}, "on_event is 3, expected a function"),
        ({"workers": "many"}, "workers is 'many', expected a whole number"),
        ({"until": "soon"}, "until is 'soon', expected a number"),
        ({"seed": -1}, "seed"),
        ({"task": "fly"}, "no task is called `fly`"),
        ({"workers": 0}, "workers"),
        ({"config": "nowhere.toml"}, "nowhere.toml"),
    ],
)
def test_wrong_settings_are_named_and_leave_no_run(arguments, message, out):
    arguments = {"task": "push"} | arguments
    with pytest.raises(rher.RherError, match=message) as error:
        rher.train(**arguments, out=out)
    assert isinstance(error.value, ValueError)
    assert not (out / "checkpoint").exists()


def test_settings_files_are_those_of_the_command_line(tiny, out, tmp_path):
    file = tmp_path / "settings.toml"
    file.write_text('[task]\nname = "push"\n[agent]\ndiscount = 0.9\n')
    run = rher.train("push", config=file, set=tiny, env_steps=50, out=out)
    assert run.settings["agent"]["discount"] == pytest.approx(0.9)
    with pytest.raises(rher.SettingsError, match="for task `push`, not `pick`"):
        rher.train("pick", config=file, out=tmp_path / "other")


def test_recipes_of_tasks_are_used(tiny, out):
    run = rher.train("reach", set=tiny, env_steps=50, out=out)
    assert run.settings["env_steps"] == 50
    run = rher.train("cue-push", set=tiny, env_steps=20, out=out.with_name("cue"))
    assert run.settings["relay"]["reach_distance"] == pytest.approx(0.04)


def test_a_folder_holds_one_run(tiny, out):
    rher.train("push", set=tiny, env_steps=50, out=out)
    with pytest.raises(rher.FileError, match="already holds a run"):
        rher.train("push", set=tiny, env_steps=50, out=out)
    with pytest.raises(OSError, match="holds no run"):
        rher.resume(out.with_name("other"))
    with pytest.raises(rher.FileError, match="holds no run"):
        rher.Run(out.with_name("other"))


def test_damaged_runs_are_named(tiny, out):
    rher.train("push", set=tiny, env_steps=250, out=out)
    checkpoint = out / "checkpoint" / "current.ckpt"
    data = bytearray(checkpoint.read_bytes())
    data[len(data) // 2] ^= 1
    checkpoint.write_bytes(data)
    with pytest.raises(rher.FileError, match="current.ckpt` is damaged"):
        rher.resume(out)
    metrics = out / "metrics.jsonl"
    metrics.write_text("{]\n" + metrics.read_text())
    with pytest.raises(rher.FileError, match="metrics.jsonl` is damaged"):
        rher.Run(out).metrics  # noqa: B018


def test_reach_is_learned(out):
    run = rher.train("reach", out=out)
    assert run.metrics["success_final"][-1] >= 0.95


def test_a_run_starts_from_that_of_another_task(tiny, tmp_path):
    both = {**tiny, "agent.critic_layer_norm": True}
    first = rher.train("push", set=both, env_steps=500, out=tmp_path / "push")
    run = rher.train(
        "dpush", set=both, env_steps=300, out=tmp_path / "dpush", from_run=first.path
    )
    source = run.settings["from"]
    assert source["task"] == "push" and source["updates"] == first.metrics["updates"][-1]
    assert "from" not in first.settings

    again = rher.resume(run.path, env_steps=600)
    assert again.settings["from"] == source


def test_a_run_that_does_not_fit_is_refused_before_a_folder_is_made(tiny, tmp_path):
    first = rher.train("push", set=tiny, env_steps=500, out=tmp_path / "push")
    out = tmp_path / "new"
    with pytest.raises(rher.SettingsError, match="its object 1 is `block1`, expected `puck1`"):
        rher.train("slide", set=tiny, out=out, from_run=first.path)
    with pytest.raises(rher.SettingsError, match=r"its `agent.hidden` is \[16,16\]"):
        rher.train("push", set={**tiny, "agent.hidden": [8]}, out=out, from_run=first.path)
    with pytest.raises(rher.FileError, match="there is no checkpoint in it"):
        rher.train("push", set=tiny, out=out, from_run=tmp_path)
    with pytest.raises(rher.InputError, match="from_run is 3, expected a path"):
        rher.train("push", set=tiny, out=out, from_run=3)
    assert not out.exists()
