"""The control loop of the examples, on a robot that breaks."""

import sys
from pathlib import Path

import numpy as np
import pytest
from robot import SimulatedRobot

import rher

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from control_loop import Limits, Stopped, control  # noqa: E402

STEPS, PERIOD = 50, 0.04


def run(robot, task="push", limits=Limits(action=1.0, change=2.0), steps=STEPS):
    policy = rher.Policy.pretrained(task)
    goal = robot.env.reset(seed=robot.seed)[0]["desired_goal"]
    try:
        return control(robot, policy, goal, steps, limits, now=robot.now, sleep=robot.sleep)
    finally:
        assert not robot.is_connected


@pytest.mark.parametrize(("name", "task"), [("rher/Push-v0", "push"), ("rher/DPush-v0", "dpush")])
def test_a_policy_does_its_task_through_dictionaries(name, task):
    robots = [SimulatedRobot(name, seed) for seed in range(10)]
    steps = robots[0].env.spec.max_episode_steps
    holds = [run(robot, task, steps=steps) for robot in robots]
    assert holds == [0] * 10
    assert np.mean([robot.info["is_success"] for robot in robots]) >= 0.9
    moments = np.array([moment for moment, _ in robots[0].sent])
    assert np.allclose(np.diff(moments), PERIOD)


def test_actions_keep_within_limits():
    robot = SimulatedRobot()
    run(robot, limits=Limits(action=0.5, change=0.2))
    actions = np.array([action for _, action in robot.sent])
    assert np.abs(actions).max() <= 0.5
    # The last one is the hold at the end.
    assert np.abs(np.diff(actions[:-1], axis=0, prepend=0)).max() <= 0.2 + 1e-9
    assert not actions[-1].any()


def lose(robot, numbers):
    if robot.readings % 3 == 0:
        raise ConnectionError("a message was lost")


def blind(robot, numbers):
    if robot.readings > 4:
        numbers["block1.position.x"] = np.nan


def slow(robot, numbers):
    if robot.readings > 4:
        robot.clock += 0.5


def unplug(robot, numbers):
    if robot.readings > 4:
        raise RuntimeError("the cable is out")


def stall(robot, numbers):
    if robot.readings == 5:
        robot.clock += 0.08


def test_an_arm_holds_where_a_message_is_lost():
    robot = SimulatedRobot(fault=lose)
    assert run(robot) == STEPS // 3
    held = [action for index, (_, action) in enumerate(robot.sent[:STEPS]) if index % 3 == 2]
    assert not np.any(held)


@pytest.mark.parametrize("fault", [blind, slow])
def test_an_arm_stops_where_nothing_usable_comes(fault):
    robot = SimulatedRobot(fault=fault)
    with pytest.raises(Stopped, match="no usable observation for 5 periods"):
        run(robot)
    # Four moves, five holds, and the hold at the end.
    assert len(robot.sent) == 10
    assert not np.any([action for _, action in robot.sent[4:]])


def test_an_arm_holds_and_is_disconnected_after_any_exception():
    robot = SimulatedRobot(fault=unplug)
    with pytest.raises(RuntimeError, match="the cable is out"):
        run(robot)
    assert len(robot.sent) == 5
    assert not np.any(robot.sent[-1][1])


def test_what_a_stall_has_missed_is_not_made_up_for_in_a_burst():
    robot = SimulatedRobot(fault=stall)
    assert run(robot) == 0
    gaps = np.diff([moment for moment, _ in robot.sent])
    assert gaps.min() >= PERIOD - 1e-9
    assert np.isclose(gaps.max(), PERIOD + 0.08)


def test_a_policy_for_another_robot_never_connects_to_this_one():
    robot = SimulatedRobot()
    robot.names["observation"] = robot.names["observation"][:-1]
    with pytest.raises(Stopped, match="has no finger2.velocity"):
        run(robot)
    assert robot.sent == []


def test_the_robot_is_one_of_lerobot(tmp_path):
    robots = pytest.importorskip("lerobot.robots", reason="LeRobot is not installed")

    class Ours(SimulatedRobot, robots.Robot):
        config_class, name = robots.RobotConfig, "ours"
        is_calibrated = True

        def __init__(self):
            robots.Robot.__init__(self, robots.RobotConfig(id="1", calibration_dir=tmp_path))
            SimulatedRobot.__init__(self)

        def calibrate(self):
            pass

        def configure(self):
            pass

    robot = Ours()
    assert run(robot) == 0
    assert robot.info["is_success"]
