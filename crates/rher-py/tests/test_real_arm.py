"""Learning on an arm that is slow, loses messages, and is reset by a person."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from slow_arm import SlowArm

import rher

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from real_arm import GoHome, RealArm, ask_on_terminal  # noqa: E402

STEPS = 40
BOX = ((0.2, 0.2, 0.2), (0.8, 0.8, 0.8))
#: Settings with which a run spares the person.
SETTINGS = {
    "agent.hidden": [64, 64],
    "evaluation.every_episodes": 25,
    "evaluation.episodes": 10,
    "evaluation.subtask_episodes": 1,
}


def real_arm(arm=None, ask=lambda question: None, **arguments):
    arm = arm or SlowArm()
    return RealArm(arm, BOX, ask, steps=STEPS, now=arm.now, sleep=arm.sleep, **arguments)


def trainer(env, out, **arguments):
    arguments = {"set": SETTINGS, "out": out} | arguments
    return rher.Trainer(env, objects=0, episode_steps=STEPS, workers=1, **arguments)


@pytest.mark.parametrize(("late", "lost"), [(0.0, 0.0), (0.08, 0.1)])
def test_an_arm_learns_to_reach_although_its_messages_are_late_and_lost(late, lost, out):
    arm = SlowArm(late=late, lost=lost)
    env = rher.StepLog(real_arm(arm), out.with_suffix(".jsonl"))
    fresh = trainer(env, out)
    run = fresh.learn(env_steps=8000, until=0.9)
    assert run.metrics["success_final"][-2:].min() >= 0.9
    taken = env.taken
    print(
        f"{late} s late, {lost:.0%} lost: {fresh.env_steps} steps learned from, {taken.steps} taken, "
        f"{taken.resets} resets, {arm.time / 60:.0f} minutes of the arm"
    )
    ends = []
    for seed in range(20):
        seen, _ = env.reset(seed=1000 + seed)
        for _ in range(STEPS):
            seen, *_ = env.step(fresh.policy(seen))
        # Where the hand is, and not where it is said to be.
        ends.append(np.linalg.norm(arm.hand - seen["desired_goal"]) <= 0.05)
    assert np.mean(ends) >= 0.8


def test_the_arm_stands_still_until_the_person_is_ready(out):
    arm, waiting, ready = SlowArm(), threading.Event(), threading.Event()
    asked = []

    def ask(question):
        asked.append(arm.moves)
        if len(asked) == 5:
            waiting.set()
            assert ready.wait(60)

    training = trainer(real_arm(arm, ask), out)
    learning = threading.Thread(target=training.learn, kwargs={"env_steps": 5 * STEPS})
    learning.start()
    assert waiting.wait(60)
    moves, moment = arm.moves, arm.time
    time.sleep(1.0)
    assert (arm.moves, arm.time) == (moves, moment)
    ready.set()
    learning.join()
    assert training.env_steps == 5 * STEPS


def test_every_step_of_the_arm_is_counted(out, tmp_path):
    class Fragile(SlowArm):
        broken = False

        def send_action(self, action):
            # In the middle of the fourth episode; the first two look for objects.
            if self.moves == 3 * STEPS + 7 and not self.broken:
                self.broken = True
                raise RuntimeError("the cable is out")
            return super().send_action(action)

    arm, path = Fragile(lost=0.0), tmp_path / "arm.jsonl"
    env = rher.StepLog(real_arm(arm), path)
    first = trainer(env, out)
    with pytest.raises(rher.EnvError, match="the cable is out") as error:
        first.learn(env_steps=25 * STEPS, until=0.0)
    assert "progress was saved" in str(error.value)
    # The steps of the episode that was aborted are not learned from, and were taken.
    assert first.env_steps == 3 * STEPS
    assert (env.taken.steps, env.taken.aborted_episodes) == (3 * STEPS + 8, 0)
    first.close()

    # The next process knows of them.
    again = rher.StepLog(real_arm(arm), path)
    assert again.taken == env.taken
    resumed = trainer(again, None, resume=out, set=None)
    resumed.learn(env_steps=25 * STEPS)
    taken = again.taken
    assert (taken.aborted_episodes, taken.aborted_steps) == (1, 8)
    # 25 episodes of training, and as many of evaluation as the settings say.
    evaluated = SETTINGS["evaluation.episodes"]
    assert resumed.env_steps == 25 * STEPS
    assert taken.steps == (25 + evaluated) * STEPS + 8
    lines = [json.loads(line)["kind"] for line in path.read_text().splitlines()]
    assert [lines.count(kind) for kind in ("reset", "step", "end")] == [
        taken.resets,
        taken.steps,
        25 + evaluated,
    ]


def test_the_log_is_continued_and_knows_its_own_lines(tmp_path):
    path = tmp_path / "arm.jsonl"
    env = rher.StepLog(real_arm(), path)
    env.reset(seed=0)
    for _ in range(3):
        env.step(np.zeros(3, np.float32))
    env.close()
    # A full disk cuts a line.
    path.write_bytes(path.read_bytes() + b'{"kind": "st')
    env = rher.StepLog(real_arm(), path)
    assert env.taken == rher.Taken(steps=3, resets=1)
    env.reset(seed=1)
    assert env.taken == rher.Taken(steps=3, resets=2, aborted_episodes=1, aborted_steps=3)
    path.write_text('{"loss": 1.0}\n')
    with pytest.raises(rher.FileError, match="line 1 of .* expected one of a log of steps"):
        rher.StepLog(real_arm(), path)
    with pytest.raises(rher.FileError, match="cannot use"):
        rher.StepLog(real_arm(), tmp_path)


#: Trains in a process of its own; the person is away at the reset that is asked for.
PROCESS = """
import sys, time
sys.path[:0] = {paths!r}
import rher
from test_real_arm import real_arm, trainer
from slow_arm import SlowArm

folder, asked, leave_at = sys.argv[1], [], int(sys.argv[2])

def ask(question):
    asked.append(question)
    if len(asked) == leave_at:
        print("waiting", flush=True)
        time.sleep(600)

arm = SlowArm(seed=leave_at)
# A day has passed on the arm's clock.
arm.time = 86400.0 * (leave_at == 0)
env = rher.StepLog(real_arm(arm, ask), folder + ".jsonl")
training = trainer(env, folder) if leave_at else trainer(env, None, resume=folder, set=None)
while training.env_steps < 30 * 40:
    # Saves without an evaluation.
    training.learn(env_steps=30 * 40, until=0.0, max_wall=0.2, progress=False)
print(training.env_steps, env.taken.aborted_episodes, flush=True)
"""


def process(folder, leave_at):
    here = Path(__file__).parent
    paths = [str(here), str(here.parent / "examples")]
    command = [sys.executable, "-c", PROCESS.format(paths=paths), str(folder), str(leave_at)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def test_a_run_survives_the_end_of_its_process_and_a_computer_that_sleeps(out):
    first = process(out, 20)
    assert first.stdout.readline() == "waiting\n"
    first.kill()
    first.wait()
    second = process(out, 0)
    # As a computer that sleeps for a while.
    time.sleep(3.0)
    os.kill(second.pid, signal.SIGSTOP)
    time.sleep(2.0)
    os.kill(second.pid, signal.SIGCONT)
    said, _ = second.communicate(timeout=120)
    assert second.returncode == 0
    assert said.split() == [str(30 * STEPS), "0"]


def test_an_episode_in_which_the_computer_was_asleep_is_cut_off(out):
    class Sleepy(RealArm):
        def step(self, action):
            if self.taken == 10 and self.naps:
                self.naps -= 1
                self.robot.time += 8 * 3600
            return super().step(action)

    arm = SlowArm()
    env = Sleepy(arm, BOX, lambda question: None, steps=STEPS, now=arm.now, sleep=arm.sleep)
    env.naps = 1
    seen, _ = env.reset(seed=0)
    for step in range(11):
        seen, _, _, truncated, info = env.step(np.full(3, 0.5, np.float32))
        assert truncated == (step == 10)
    assert "too long" in info["cut_off"]
    moved = arm.hand.copy()
    arm.sleep(1.0)
    assert np.array_equal(arm.hand, moved)

    env.naps = 2
    logged = rher.StepLog(env, out.with_suffix(".jsonl"))
    training = trainer(logged, out)
    training.learn(env_steps=5 * STEPS)
    # Two of the episodes had eleven steps, and all were learned from.
    assert training.env_steps >= 5 * STEPS
    assert (training.env_steps - 2 * 11) % STEPS == 0
    assert logged.taken.aborted_episodes == 0


def test_an_episode_without_readings_is_cut_off():
    arm = SlowArm(lost=0.0)
    env = real_arm(arm)
    env.reset(seed=0)
    arm.lost = 1.0
    ends = [env.step(np.ones(3, np.float32))[3] for _ in range(5)]
    assert ends == [False] * 4 + [True]


def test_the_person_can_stop_and_go_on_later(out):
    answers = iter([True] * 6 + [False] + [True] * 100)

    def ask(question):
        if not next(answers):
            raise GoHome("the person wants to stop")

    arm = SlowArm()
    env = real_arm(arm, ask)
    training = trainer(env, out)
    with pytest.raises(rher.EnvError, match="wants to stop") as error:
        training.learn(env_steps=10 * STEPS)
    assert isinstance(error.value.__cause__, GoHome)
    before = training.env_steps
    assert before > 0
    # In the same process, too.
    training.learn(env_steps=10 * STEPS)
    assert training.env_steps == 10 * STEPS
    env.close()
    assert not arm.is_connected


def test_the_terminal_is_asked(monkeypatch):
    answers = iter(["", "q"])
    monkeypatch.setattr("builtins.input", lambda prompt: next(answers))
    ask_on_terminal("Put the block back")
    with pytest.raises(GoHome):
        ask_on_terminal("Put the block back")


def test_ctrl_c_moves_the_arm_no_more(out):
    arm, asked = SlowArm(), []

    def ask(question):
        asked.append(question)
        if len(asked) == 6:
            os.kill(os.getpid(), signal.SIGINT)
            # The person answers after that.
            time.sleep(1.0)

    env = rher.StepLog(real_arm(arm, ask), out.with_suffix(".jsonl"))
    training = trainer(env, out)
    with pytest.raises(KeyboardInterrupt):
        training.learn(env_steps=100 * STEPS)
    assert len(asked) == 6
    assert training.env_steps == 3 * STEPS
    assert env.taken.steps == 3 * STEPS
    training.close()
    resumed = trainer(real_arm(arm), None, resume=out, set=None)
    assert resumed.env_steps == 3 * STEPS
    resumed.learn(env_steps=5 * STEPS)


def test_an_evaluation_in_which_the_arm_failed_is_made_again(out):
    class Fragile(SlowArm):
        broken = False

        def send_action(self, action):
            if self.moves == 25 * STEPS + 7 and not self.broken:
                self.broken = True
                raise RuntimeError("the cable is out")
            return super().send_action(action)

    training = trainer(real_arm(Fragile(lost=0.0)), out)
    with pytest.raises(rher.EnvError, match="the cable is out"):
        training.learn(env_steps=25 * STEPS, until=0.0)
    assert training.env_steps == 25 * STEPS
    run = training.learn(env_steps=25 * STEPS)
    assert list(run.metrics["env_steps"]) == [25 * STEPS]
