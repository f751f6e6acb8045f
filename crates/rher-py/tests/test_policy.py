"""Policies: what they are given, what they return, and what is refused."""

import copy
import multiprocessing
import pickle
from types import MappingProxyType

import gymnasium
import numpy as np
import pytest
import rher
from toy import STEPS, Carry


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """The policy of a short run on every task that the tests name."""
    folder = tmp_path_factory.mktemp("policies")
    tiny = {"agent.hidden": [16, 16], "replay.batch_size": 16, "evaluation.episodes": 2}

    def of(task):
        run = folder / task
        if not run.exists():
            rher.train(task, set=tiny, env_steps=100, out=run)
        return run / "policy.safetensors"

    return of


@pytest.mark.parametrize(("name", "task"), rher.IDS.items())
def test_an_observation_alone_or_with_its_parts_gives_the_same_action(name, task, path):
    policy = rher.Policy.load(path(task))
    env = gymnasium.make(name)
    observation, _ = env.reset(seed=0)
    for _ in range(5):
        action = policy(observation)
        assert action.shape == env.action_space.shape and action.dtype == np.float32
        assert np.abs(action).max() <= 1
        parts = policy(observation["observation"], observation["desired_goal"])
        assert np.array_equal(parts, action)
        observation, *_ = env.step(action)


@pytest.mark.parametrize("name", ["rher/Push-v0", "rher/DPush-v0"])
def test_a_batch_is_its_rows(name, path):
    policy = rher.Policy.load(path(rher.IDS[name]))
    envs = gymnasium.make_vec(name, num_envs=5)
    observations, _ = envs.reset(seed=0)
    actions = policy(observations)
    assert actions.shape == (5, 4)
    for row in range(5):
        one = {key: value[row] for key, value in observations.items()}
        assert np.array_equal(policy(one), actions[row])
    assert policy({key: value[:0] for key, value in observations.items()}).shape == (0, 4)
    assert np.array_equal(envs.step(actions)[0]["desired_goal"], observations["desired_goal"])


def test_a_policy_that_begins_an_episode_takes_rows_of_it_alone(path):
    policy = rher.Policy.load(path("dpush"))
    envs = gymnasium.make_vec("rher/DPush-v0", num_envs=3)
    observations, _ = envs.reset(seed=0)
    begun = policy.begin(observations)
    assert np.array_equal(begun(observations), policy(observations)), "nothing learned to choose by"
    again = pickle.loads(pickle.dumps(begun))
    assert np.array_equal(again(observations), begun(observations))
    two = {key: value[:2] for key, value in observations.items()}
    for other in (begun, again):
        with pytest.raises(ValueError, match="2 rows, but 3 episodes have begun"):
            other(two)


def test_goals_matter(path):
    policy = rher.Policy.load(path("push"))
    observation, _ = gymnasium.make("rher/Push-v0").reset(seed=0)
    there = policy(observation["observation"], observation["desired_goal"])
    elsewhere = policy(observation["observation"], observation["desired_goal"] + 0.1)
    assert not np.array_equal(there, elsewhere)


def test_files_are_written_and_read(path, tmp_path):
    policy = rher.Policy.load(path("push"))
    policy.save(tmp_path / "copy.safetensors")
    copy = rher.Policy.load(tmp_path / "copy.safetensors")
    observation, _ = gymnasium.make("rher/Push-v0").reset(seed=0)
    assert np.array_equal(copy(observation), policy(observation))
    assert (copy.task, copy.objects, copy.observation_width, copy.action_width) == ("push", 1, 25, 4)
    with pytest.raises(rher.FileError):
        policy.save(tmp_path / "no" / "where.safetensors")


@pytest.mark.parametrize("name", ["rher/Reach-v0", "rher/DrawerBox-v0"])
def test_policies_are_copied_and_pickled(name, path):
    policy = rher.Policy.load(path(rher.IDS[name]))
    seen, _ = gymnasium.make(name).reset(seed=0)
    for twin in (pickle.loads(pickle.dumps(policy)), copy.copy(policy), copy.deepcopy(policy)):
        assert repr(twin) == repr(policy)
        assert np.array_equal(twin(seen), policy(seen))
    with pytest.raises(rher.PolicyError, match="a pickled policy"):
        rher.Policy._from_bytes(b"junk" * 100)


def test_policies_go_to_processes_that_are_spawned(path):
    policy = rher.Policy.load(path("push"))
    seen, _ = gymnasium.make("rher/Push-v0").reset(seed=0)
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        actions = pool.starmap(policy, [(seen,)] * 3)
        again = pool.apply(policy.begin(seen), (seen,))
    assert all(np.array_equal(action, policy(seen)) for action in [*actions, again])


def test_every_mapping_is_an_observation(path):
    policy = rher.Policy.load(path("push"))
    seen, _ = gymnasium.make("rher/Push-v0").reset(seed=0)
    assert np.array_equal(policy(MappingProxyType(seen)), policy(seen))


def test_a_number_that_is_not_finite_is_named_with_its_row(path):
    policy = rher.Policy.load(path("push"))
    seen, _ = gymnasium.make_vec("rher/Push-v0", num_envs=3).reset(seed=0)
    for key, field in [("observation", "observation"), ("desired_goal", "desired")]:
        wrong = {name: array.copy() for name, array in seen.items()}
        wrong[key][2, 1] = np.nan
        with pytest.raises(rher.InputError, match=f"row 2: number 1 of `{field}` is NaN"):
            policy(wrong)


def test_files_that_are_no_policies_are_named(tmp_path, path):
    with pytest.raises(OSError, match="nowhere"):
        rher.Policy.load(tmp_path / "nowhere.safetensors")
    junk = tmp_path / "junk.safetensors"
    junk.write_bytes(b"junk" * 100)
    with pytest.raises(rher.PolicyError, match="junk.safetensors"):
        rher.Policy.load(junk)
    junk.write_bytes(path("push").read_bytes()[:-100])
    with pytest.raises(rher.PolicyError):
        rher.Policy.load(junk)


def test_a_policy_for_another_task_is_refused(path):
    policy = rher.Policy.load(path("push"))
    observation, _ = gymnasium.make("rher/DPush-v0").reset(seed=0)
    with pytest.raises(rher.InputError, match="for another task"):
        policy(observation)
    observation, _ = gymnasium.make("rher/Reach-v0").reset(seed=0)
    with pytest.raises(rher.InputError, match=r"shape \[10\], expected \(25,\)"):
        policy(observation)


@pytest.mark.parametrize(
    "arguments",
    [
        (np.zeros(25),),
        (np.zeros(25), np.zeros(4)),
        (np.zeros((2, 25)), np.zeros(3)),
        (np.full(25, np.nan), np.zeros(3)),
        ("there", np.zeros(3)),
        ({"observation": np.zeros(25)},),
        ({},),
        (None, None),
    ],
    ids=repr,
)
def test_wrong_arguments_are_refused(arguments, path):
    with pytest.raises(rher.InputError):
        rher.Policy.load(path("push"))(*arguments)


@pytest.mark.parametrize("name", ["rher/Reach-v0", "rher/Stack-v0"])
def test_a_policy_of_every_task_ships_with_the_package(name):
    policy = rher.Policy.pretrained(rher.IDS[name])
    env = gymnasium.make(name)
    solved = 0
    for seed in range(10):
        observation, _ = env.reset(seed=seed)
        truncated = False
        while not truncated:
            observation, _, _, truncated, info = env.step(policy(observation))
        solved += info["is_success"]
    assert solved >= 8
    with pytest.raises(ValueError, match="no task is called `nothing`"):
        rher.Policy.pretrained("nothing")


def test_a_policy_says_what_its_numbers_are(tiny, out):
    policy = rher.Policy.pretrained("push")
    assert policy.names["objects"] == ["block1"]
    assert policy.names["observation"][:4] == [
        "gripper.position.x",
        "gripper.position.y",
        "gripper.position.z",
        "block1.position.x",
    ]
    assert len(policy.names["action"]) == policy.action_width
    control = policy.control
    assert control["rate_hz"] == 25.0
    assert "x forward" in control["frame"]
    assert len(control["observation_units"]) == policy.observation_width
    assert control["action_units"][0] == "0.05 m/step"
    # Nobody knows those of an environment of one's own.
    mine = rher.Trainer(Carry(1), episode_steps=STEPS, set=tiny, out=out).policy
    assert mine.names == {"objects": [], "observation": [], "action": []}
    assert mine.control == {
        "rate_hz": None,
        "frame": "",
        "observation_units": [],
        "action_units": [],
    }
