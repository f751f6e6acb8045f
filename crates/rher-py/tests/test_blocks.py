"""Our tasks with several blocks in MuJoCo: what the scenes are made of, and that policies work."""

import json

import numpy as np
import pytest
import rher

pytest.importorskip("gymnasium_robotics")

from gymnasium_robotics.envs.fetch.pick_and_place import MujocoFetchPickAndPlaceEnv  # noqa: E402
from gymnasium_robotics.envs.fetch.push import MujocoFetchPushEnv  # noqa: E402
from rher.compare import block_scene, command  # noqa: E402

FETCH = {
    "dpush": MujocoFetchPushEnv,
    "stack": MujocoFetchPickAndPlaceEnv,
    "tpush": MujocoFetchPushEnv,
    "tstack": MujocoFetchPickAndPlaceEnv,
}


@pytest.fixture(scope="module", params=FETCH)
def scene(request):
    """A scene, our task, and the environment of Gymnasium-Robotics that it is made of."""
    env, fetch = block_scene.make(request.param), FETCH[request.param]()
    yield env, rher.TaskEnv(request.param), fetch
    env.close()
    fetch.close()


def test_every_task_with_blocks_has_a_scene():
    assert set(block_scene.TASKS) == set(FETCH)


def test_episodes_begin_as_ours_do(scene):
    env, ours, _ = scene
    for seed in (0, 7):
        there, _ = env.reset(seed=seed)
        here, _ = ours.reset(seed=seed)
        assert env.observation_space.contains(there)
        for goal in ("achieved_goal", "desired_goal"):
            assert there[goal] == pytest.approx(here[goal], abs=1e-6)
        # Fetch's hand begins with a little velocity, and its fingers not quite closed.
        assert there["observation"] == pytest.approx(here["observation"], abs=0.0035)
    again, _ = env.reset(seed=7)
    assert all(np.array_equal(again[key], there[key]) for key in there)
    turned, _ = env.reset(seed=7, options={"turns": [0.3] + [0.0] * (ours.objects - 1)})
    angle = block_scene.names(ours.task).index("block1.rotation.z")
    assert turned["observation"][angle] == pytest.approx(0.3)


def test_numbers_of_observations_are_where_they_are_in_ours(scene):
    env, ours, fetch = scene
    for one in (env, ours, fetch):
        one.reset(seed=3)
    names = block_scene.names(ours.task)
    # Up and aside with opening fingers, so that no two kinds of number are equal.
    action = np.array([0.5, -0.3, 1.0, 0.5], np.float32)
    for _ in range(4):
        there, here, single = (one.step(action)[0]["observation"] for one in (env, ours, fetch))
        numbers = dict(zip(names, there, strict=True))
        # The hand is the one of Fetch.
        for first, what in [(0, "position"), (20, "velocity")]:
            hand = [numbers[f"gripper.{what}.{axis}"] for axis in "xyz"]
            assert hand == pytest.approx(single[first : first + 3], abs=1e-6), what
        for first, what in [(9, "opening"), (23, "velocity")]:
            fingers = [numbers[f"{finger}.{what}"] for finger in ("finger1", "finger2")]
            assert fingers == pytest.approx(single[first : first + 2], abs=1e-6), what
    for name, number, expected in zip(names, there, here, strict=True):
        assert number == pytest.approx(expected, abs=0.012), name


def test_a_pushed_block_is_seen_where_it_is(scene):
    env, ours, _ = scene
    last = ours.objects
    env.reset(seed=0)
    hand = env.unwrapped.data.site("robot0:grip").xpos.copy()
    # The last block stands in front of the hand, the others where nothing touches them.
    others = [[hand[0] - 0.1, hand[1] + side, 0.425] for side in (-0.1, 0.1)[: last - 1]]
    layout = np.concatenate([*others, [hand[0] + 0.1, hand[1], 0.425]])
    env.reset(seed=0, options={"layout": layout})
    seen = [
        env.step(np.array(action, np.float32))[0]
        for action in 3 * [[0.0, 0.0, -1.0, 0.0]] + 5 * [[1.0, 0.0, 0.0, 0.0]]
    ]
    before, seen = seen[-2:]
    moved = (seen["achieved_goal"] - layout).reshape(-1, 3)
    assert moved[-1, 0] > 0.04
    assert np.abs(moved[:-1]).max() < 1e-3
    numbers = dict(zip(block_scene.names(ours.task), seen["observation"], strict=True))
    place = [numbers[f"block{last}.position.{axis}"] for axis in "xyz"]
    assert np.array_equal(place, seen["achieved_goal"][-3:])
    assert np.array_equal(place, env.unwrapped.data.site(f"object{last - 1}").xpos)
    # Velocities are meters in a step.
    step = seen["achieved_goal"][-3] - before["achieved_goal"][-3]
    velocity = numbers[f"block{last}.velocity.x"] + numbers["gripper.velocity.x"]
    assert step > 0.015 and velocity == pytest.approx(step, abs=0.01)


#: What a block is made of, by kind of element.
OF_A_BLOCK = {
    "body": "mass inertia ipos iquat",
    "joint": "type damping stiffness armature frictionloss solref solimp margin",
    "geom": "type size friction condim contype conaffinity solref solimp solmix margin gap matid",
}

#: The same of everything else, which comes before the blocks.
OF_THE_REST = (
    "body_mass body_inertia body_pos body_quat geom_type geom_size geom_friction geom_condim "
    "geom_solref geom_solimp geom_margin jnt_range dof_damping dof_armature"
)


def test_blocks_are_those_of_fetch_and_all_else_is_unchanged(scene):
    env, ours, fetch = scene
    model, original = env.unwrapped.model, fetch.model
    assert original.geom("object0").size == pytest.approx([0.025] * 3)
    assert original.body("object0").mass == [2.0]
    for block in range(ours.objects):
        for kind, fields in OF_A_BLOCK.items():
            joint = ":joint" if kind == "joint" else ""
            copied = getattr(model, kind)(f"object{block}{joint}")
            first = getattr(original, kind)(f"object0{joint}")
            for field in fields.split():
                assert np.array_equal(getattr(copied, field), getattr(first, field)), field
    for field in OF_THE_REST.split():
        before = len(getattr(original, field)) - (6 if field.startswith("dof") else 1)
        one, other = getattr(model, field)[:before], getattr(original, field)[:before]
        assert np.array_equal(one, other), field
    for field in ("eq_data", "eq_solref", "eq_solimp", "mesh_vert", "actuator_gainprm", "mat_rgba"):
        assert np.array_equal(getattr(model, field), getattr(original, field)), field
    assert model.nbody == original.nbody + ours.objects - 1
    assert model.nexclude == original.nexclude
    assert model.opt.timestep == original.opt.timestep
    assert env.unwrapped.n_substeps == fetch.n_substeps


def test_goals_are_marked_and_that_changes_nothing(scene):
    env, ours, _ = scene
    ends = []
    for draw in (False, True):
        env.reset(seed=1)
        for _ in range(5):
            if draw:
                env.unwrapped._render_callback()
                marks = [env.unwrapped.data.site(f"target{at}").xpos for at in range(ours.objects)]
                assert np.array_equal(np.concatenate(marks), env.unwrapped.goal)
            seen, *_ = env.step(np.array([0.7, 0.2, -0.5, 1.0], np.float32))
        ends.append(seen["observation"])
    assert np.array_equal(*ends)


def test_success_and_the_time_limit_are_ours(scene):
    env, ours, _ = scene
    seen, _ = env.reset(seed=0)
    goal = seen["achieved_goal"]
    beside = goal + np.tile([0.04, 0.0, 0.0], ours.objects)
    _, _, _, truncated, info = started_at(env, beside)
    assert info["is_success"] is True and not truncated
    beside[-3] += 0.02
    _, reward, _, _, info = started_at(env, beside)
    assert info["is_success"] is False and reward == -1.0
    for _ in range(ours.episode_steps - 1):
        assert not truncated
        _, _, terminated, truncated, _ = env.step(np.zeros(4, np.float32))
    assert truncated and not terminated


def started_at(env, goal):
    """What the first step of an episode with this goal returns, in which nothing moves."""
    env.reset(seed=0, options={"goal": goal})
    return env.step(np.zeros(4, np.float32))


def test_policies_that_ship_work_there(out):
    command.main(["--quick", "--parts", "blocks", "--out", str(out)])
    found = json.loads((out / "compare.json").read_text())["blocks"]
    failed = {one["task"]: len(one["failures"]["mujoco"]) for one in found["policies"]}
    assert set(failed) == set(FETCH)
    assert max(failed["dpush"], failed["stack"]) <= found["episodes"] // 2
    assert "ships for tpush" in (out / "compare.md").read_text()


def test_policies_of_other_tasks_are_refused(tmp_path):
    path = tmp_path / "push.safetensors"
    rher.Policy.pretrained("push").save(path)
    with pytest.raises(rher.InputError, match="is a policy of `push`, expected one of dpush"):
        command.main(["--parts", "blocks", "--blocks", str(path), "--out", str(tmp_path)])
