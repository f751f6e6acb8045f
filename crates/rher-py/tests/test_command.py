"""The command ``rher`` of the package is the program that cargo builds."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

#: The command of this interpreter's environment, and the same as a module.
COMMANDS = {
    "script": [str(Path(sys.executable).with_name("rher"))],
    "module": [sys.executable, "-m", "rher_command"],
}
#: Arguments that make a run take a second or less.
TINY = (
    "--until 0 --set agent.hidden=[16,16] --set replay.batch_size=16 "
    "--set replay.updates_per_episode=2 --set evaluation.every_episodes=5 "
    "--set evaluation.episodes=5 --set evaluation.subtask_episodes=2"
)

TINY_FILE = """
[agent]
hidden = [16, 16]
[replay]
batch_size = 16
updates_per_episode = 2
[evaluation]
every_episodes = 5
episodes = 5
subtask_episodes = 2
"""


def told(command, arguments, folder):
    """Exit status, standard output and standard error."""
    ran = subprocess.run(
        [*command, *arguments.split()], cwd=folder, capture_output=True, text=True, check=False
    )
    return ran.returncode, ran.stdout, ran.stderr


@pytest.fixture
def program():
    """The program that cargo built."""
    path = os.environ.get("RHER")
    if path is None:
        pytest.skip("RHER does not name the program")
    return [path]


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
@pytest.mark.parametrize(
    "arguments",
    ["--version", "--help", "tasks --json", "config pick", "", "sit", "train", "stats nowhere"],
)
def test_it_says_what_the_program_says(program, command, arguments, tmp_path):
    assert told(command, arguments, tmp_path) == told(program, arguments, tmp_path)


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_its_runs_have_the_same_bits(program, command, tmp_path):
    arguments = "sweep push --env-steps 500 --until 0 --seeds 1,2 --set relay.mirror=0"
    (tmp_path / "tiny.toml").write_text(TINY_FILE)
    for name, run in {"ours": command, "theirs": program}.items():
        status, _, said = told(run, f"{arguments} --config tiny.toml --out {name}", tmp_path)
        assert status == 0, said
    run = "relay.mirror=0,seed=2"
    policies = [tmp_path / name / run / "policy.safetensors" for name in ("ours", "theirs")]
    assert policies[0].read_bytes() == policies[1].read_bytes()


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
@pytest.mark.parametrize("name, status", [("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 129)])
def test_a_signal_saves_the_run_and_ends_it(command, name, status, tmp_path):
    arguments = f"train push --out run {TINY}".split()
    running = subprocess.Popen(
        [*command, *arguments],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        # Tests that run under `nohup` ignore SIGHUP, and what they start does, too.
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),
    )
    metrics = tmp_path / "run" / "metrics.jsonl"
    deadline = time.monotonic() + 60
    while not (metrics.exists() and metrics.stat().st_size):
        assert time.monotonic() < deadline, "no metrics after a minute"
        time.sleep(0.01)
    running.send_signal(getattr(signal, name))
    _, said = running.communicate(timeout=60)
    assert running.returncode == status, said
    assert "`rher train --resume run` continues the run" in said
    assert "Traceback" not in said


def test_ctrl_c_ends_a_command_that_does_not_listen(tmp_path):
    running = subprocess.Popen(
        [*COMMANDS["script"], "bench", "update"], cwd=tmp_path, stderr=subprocess.PIPE, text=True
    )
    time.sleep(1)
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=60)
    assert running.returncode == -signal.SIGINT
    assert "Traceback" not in said


def test_it_imports_neither_numpy_nor_gymnasium(tmp_path):
    listing = subprocess.run(
        [sys.executable, "-X", "importtime", *COMMANDS["script"], "config", "push"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    ).stderr
    imported = {line.rsplit("|", 1)[-1].strip() for line in listing.splitlines()}
    assert "rher_command" in imported
    packages = {name.split(".")[0] for name in imported}
    assert not packages & {"numpy", "gymnasium", "rher"}


def test_tasks_are_those_of_the_package(tmp_path):
    import rher

    _, listing, _ = told(COMMANDS["script"], "tasks --json", tmp_path)
    assert [task["name"] for task in json.loads(listing)] == rher.tasks()
