"""What is seen of a run while it trains."""

import logging
import os
import signal
import subprocess
import sys
import threading

import gymnasium
import pytest
import rher
from toy import Carry


def test_lines_in_the_log_say_how_far_it_is(tiny, out, caplog, capsys):
    caplog.set_level(logging.INFO, logger="rher")
    rher.train("push", set=tiny, env_steps=500, until=0.9, out=out)
    lines = [record.message for record in caplog.records if record.name == "rher"]
    assert lines[0] == "push: trains until success 90% in two evaluations, at most 500 steps"
    assert lines[1].startswith("push: 250 steps: reach ") and " · push " in lines[1]
    assert lines[-1] == "push: all steps taken after 500 steps"
    assert capsys.readouterr().err == ""


def test_a_run_is_quiet_unless_somebody_looks(tiny, out, capfd):
    rher.train("push", set=tiny, env_steps=250, out=out)
    assert capfd.readouterr() == ("", "")


def test_a_bar_shows_steps_and_every_evaluation(tiny, out, capsys):
    pytest.importorskip("tqdm")
    rher.train("push", set=tiny, env_steps=500, until=0.9, out=out, progress=True)
    said = capsys.readouterr().err
    assert "500 of at most 500 steps [" in said
    assert said.count(" steps: reach ") == 2 and "all steps taken after 500 steps" in said
    rher.resume(out, env_steps=1000, until=0, progress=True)
    said = capsys.readouterr().err
    assert "trains for 1,000 steps" in said and "| 1.00k/1.00k [" in said


def test_nothing_is_shown_where_nothing_is_asked_for(tiny, out, caplog, capfd):
    caplog.set_level(logging.INFO, logger="rher")
    rher.train("push", set=tiny, env_steps=250, out=out, progress=False)
    assert not caplog.records and capfd.readouterr() == ("", "")
    with pytest.raises(rher.InputError, match="progress is 'bar', expected True, False or None"):
        rher.resume(out, env_steps=500, progress="bar")


def test_environments_of_ones_own_have_progress(tiny, out, caplog):
    caplog.set_level(logging.INFO, logger="rher")
    env = gymnasium.wrappers.TimeLimit(Carry(), 25)
    with rher.Trainer(env, set=tiny, episode_steps=25, out=out, name="carry") as trainer:
        trainer.learn(env_steps=250)
    lines = [record.message for record in caplog.records]
    assert lines[1].startswith("carry: 125 steps: reach ") and " · place " in lines[1]


def test_ctrl_c_ends_the_bar_and_saves(tiny, out, capsys):
    pytest.importorskip("tqdm")
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        rher.train("push", set=tiny, env_steps=10_000_000, until=0, out=out, progress=True)
    assert "push: interrupted after " in capsys.readouterr().err
    assert rher.Run(out).state == "stopped"
    rher.resume(out, env_steps=int(rher.Run(out).metrics["env_steps"][-1]) + 250)


def test_neither_tqdm_nor_pandas_nor_sb3_is_imported_with_the_package():
    code = (
        "import sys, rher\n"
        "print(sorted({'tqdm', 'pandas', 'stable_baselines3', 'torch', 'ray'} & set(sys.modules)))"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout == "[]\n"
