"""NumPy's numbers and arrays are taken wherever numbers are, and messages name the argument."""

import gymnasium
import numpy as np
import pytest
import rher
from test_vector import assert_same, together
from toy import STEPS, Carry


def test_numbers_of_numpy_are_settings(out, tmp_path, tiny):
    sizes = {
        "agent.hidden": np.array([16, 16]),
        "replay.batch_size": np.int64(16),
        "replay.updates_per_episode": np.uint8(2),
        "agent.discount": np.float32(0.5),
        "relay.mirror": np.float64(0.25),
        "evaluation.every_episodes": np.array(5),
        "evaluation.episodes": np.int16(5),
        "randomize.friction": np.array([0.5, 1.5], np.float32),
    }
    run = rher.train(
        "push",
        seed=np.uint32(3),
        set=sizes,
        env_steps=np.int64(100),
        until=np.float32(0.5),
        workers=np.int8(1),
        out=out,
    )
    settings = run.settings
    assert settings["agent"]["hidden"] == [16, 16] and settings["agent"]["discount"] == 0.5
    assert settings["seed"] == 3 and settings["env_steps"] == 100 and settings["until"] == 0.5
    assert settings["randomize"]["friction"] == [0.5, 1.5]
    with rher.Trainer(
        Carry(2),
        objects=np.int64(2),
        tolerance=np.array(0.1),
        episode_steps=np.int32(STEPS),
        set=tiny,
        out=tmp_path / "foreign",
    ) as trainer:
        assert trainer.learn(env_steps=np.int64(2 * STEPS), until=np.float64(0)).path.exists()


def test_numbers_of_numpy_make_environments():
    randomize = {"friction": np.array([0.5, 1.5]), "action_delay": np.array([0, 1])}
    one = rher.TaskEnv("push", randomize=randomize, width=np.int64(64), height=np.array(48))
    other = rher.TaskEnv("push", randomize={"friction": (0.5, 1.5), "action_delay": [0, 1]})
    assert_same(*(env.reset(seed=seed)[0] for env, seed in [(one, np.array(3)), (other, 3)]))
    seen = rher.TaskEnv("cue-push", options={"noise": np.float32(0)}).reset(seed=np.uint64(1))[0]
    assert_same(seen, rher.TaskEnv("cue-push", options={"noise": 0}).reset(seed=1)[0])
    many = rher.TaskVectorEnv("push", np.int64(3), threads=np.array(2))
    assert_same(many.reset(seed=np.int64(4)), together().reset(seed=4))
    assert_same(many.reset(seed=np.array([9, 8, 7])), together().reset(seed=[9, 8, 7]))


def test_seeds_go_up_to_the_last_one():
    last = 2**64 - 1
    env = gymnasium.make("rher/Push-v0")
    first = env.reset(seed=last)[0]
    assert_same(env.reset(seed=np.uint64(last))[0], first)
    many = together(envs=2)
    row = many.reset(seed=last - 1)[0]["observation"][1]
    assert np.array_equal(row, first["observation"])
    with pytest.raises(rher.InputError, match="seed is 18446744073709551615"):
        many.reset(seed=last)


@pytest.mark.parametrize(
    ("use", "message"),
    [
        (lambda: rher.TaskEnv(3), "task is 3"),
        (lambda: rher.TaskEnv("push", width=2.5), "width is 2.5"),
        (lambda: rher.TaskEnv("push", height=True), "height is True"),
        (lambda: rher.TaskEnv("push", options={1: 2}), "a key of options is 1"),
        (lambda: rher.TaskEnv("push").set_state(3), "state is 3, expected what get_state returned"),
        (lambda: rher.TaskVectorEnv("push", 2.5), "num_envs is 2.5"),
        (lambda: rher.TaskVectorEnv("push", 2, threads="all"), "threads is 'all'"),
        (lambda: rher.TaskVectorEnv("push", 2).reset(seed="x"), "seed is 'x'"),
        (lambda: rher.Run(3), "path is 3, expected a path"),
        (lambda: rher.resume(3), "path is 3, expected a path"),
        (lambda: rher.Trainer(Carry(1), objects="two"), "objects is 'two'"),
        (lambda: rher.Trainer(Carry(1), episode_steps=1.5), "episode_steps is 1.5"),
        (lambda: rher.Trainer(Carry(1), episode_steps=STEPS, gripper=3), "gripper is 3"),
        (lambda: rher.Trainer(Carry(1), episode_steps=STEPS, tolerance="near"), "tolerance is 'near'"),
        (lambda: rher.Trainer(Carry(1), episode_steps=STEPS, name=3), "name is 3"),
    ],
)
def test_what_is_wrong_is_named_by_one_tree_of_exceptions(use, message):
    with pytest.raises(rher.InputError, match=message):
        use()
