"""Forked processes, and how many threads there are."""

import os
import pickle
import select
import signal
import subprocess
import sys
import traceback

import gymnasium
import numpy as np
import pytest
import rher
from test_vector import actions, assert_same, together
from toy import STEPS, Carry

PATIENCE = 60.0


def in_child(work):
    """What ``work`` returns in a forked process, which is ended if it hangs."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        try:
            with os.fdopen(writer, "wb") as pipe:
                pipe.write(pickle.dumps(work()))
        except BaseException:  # noqa: BLE001
            traceback.print_exc()
        finally:
            os._exit(0)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        answers = select.select([pipe], [], [], PATIENCE)[0]
        if not answers:
            os.kill(child, signal.SIGKILL)
        result = pipe.read()
    os.waitpid(child, 0)
    assert answers, "the forked process hung"
    assert result, "the forked process failed; its error is above"
    return pickle.loads(result)


@pytest.mark.parametrize("threads", [1, 3])
def test_environments_that_were_stepped_go_on_in_a_forked_process(threads):
    envs, alone = (together(envs=5, threads=threads) for _ in "ab")
    first, *others = actions(5, 10)
    for env in (envs, alone):
        env.reset(seed=0)
        env.step(first)

    def work():
        return [envs.step(action) for action in others], envs.reset(seed=3)

    expected = [alone.step(action) for action in others], alone.reset(seed=3)
    found, started = in_child(work)
    for one, other in zip(found, expected[0]):
        assert_same(one, other)
    assert_same(started, expected[1])
    # The parent's are where they were, and a child of a child works, too.
    alone.reset(seed=0)
    alone.step(first)
    assert_same(envs.step(others[0]), alone.step(others[0]))
    found = in_child(lambda: in_child(lambda: envs.step(others[1])))
    assert_same(found, alone.step(others[1]))


def test_a_forked_process_may_drop_environments_and_policies(tmp_path):
    envs = together(envs=4, threads=2)
    envs.reset(seed=0)
    env = gymnasium.make("rher/Push-v0")
    env.reset(seed=0)

    def work():
        seen = env.step(np.zeros(4))[0]["observation"]
        envs.close()
        return seen

    assert np.array_equal(in_child(work), env.step(np.zeros(4))[0]["observation"])
    envs.step(np.zeros((4, 4)))


def test_the_folder_of_a_closed_trainer_is_free_although_a_child_lives(tiny, out):
    trainer = rher.Trainer(Carry(1), episode_steps=STEPS, set=tiny, out=out)
    trainer.learn(env_steps=5 * STEPS)
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(writer)
        os.read(reader, 1)
        os._exit(0)
    os.close(reader)
    try:
        with pytest.raises(rher.FileError, match="in use"):
            rher.Trainer(Carry(1), episode_steps=STEPS, resume=out)
        trainer.close()
        with rher.Trainer(Carry(1), episode_steps=STEPS, resume=out) as again:
            assert again.env_steps == 5 * STEPS
            # What a forked process closes is its own copy.
            in_child(lambda: again.close() or True)
            with pytest.raises(rher.FileError, match="in use"):
                rher.Trainer(Carry(1), episode_steps=STEPS, resume=out)
    finally:
        os.close(writer)
        os.waitpid(child, 0)


COUNT = """
import os, gymnasium, numpy as np, rher
os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})
before = len(os.listdir("/proc/self/task"))
envs = gymnasium.make_vec("rher/Push-v0", num_envs=%d%s)
envs.reset(seed=0)
print(len(os.listdir("/proc/self/task")) - before)
"""


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="only Linux has affinities")
@pytest.mark.parametrize(
    ("envs", "arguments", "threads"),
    [(8, "", 1), (8, ", threads=3", 3), (2, ", threads=64", 2)],
)
def test_threads_are_those_that_are_allowed_and_no_more_than_environments(
    envs, arguments, threads
):
    command = [sys.executable, "-c", COUNT % (envs, arguments)]
    found = subprocess.run(command, capture_output=True, text=True, check=True)
    assert int(found.stdout) == threads
