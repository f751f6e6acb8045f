"""A policy on a robot with the interface of LeRobot: a control loop at the policy's rate, with limits.

A robot has ``connect`` and ``disconnect``; ``get_observation`` returns a dictionary of numbers by
name, and ``send_action`` takes one. Their names are those of the policy: ``policy.names``.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

import rher


class Robot(Protocol):
    """What is needed of ``lerobot.robots.Robot``."""

    observation_features: dict[str, Any]
    action_features: dict[str, Any]

    def connect(self) -> None: ...
    def get_observation(self) -> dict[str, Any]: ...
    def send_action(self, action: dict[str, Any]) -> dict[str, Any]: ...
    def disconnect(self) -> None: ...


@dataclass(frozen=True)
class Limits:
    """When to hold, when to stop, and how far an action may go."""

    #: Largest magnitude of a number in an action, and its largest change from one to the next.
    action: float = 0.8
    change: float = 0.4
    #: Seconds that reading the robot may take; the arm holds after a slower one.
    latest: float = 0.1
    #: Consecutive periods without a usable observation after which the arm stops.
    patience: int = 5


class Stopped(Exception):
    """The episode ended before its time."""


def check(robot: Robot, policy: rher.Policy) -> float:
    """The period of an action in seconds, if the robot has every number that the policy knows.

    Units and frame are words: compare ``policy.control`` with what the robot's driver says of its
    own before anything moves.
    """
    rate = policy.control["rate_hz"]
    if rate is None or not policy.names["observation"]:
        raise Stopped("the policy says neither its rate nor its names: expected both")
    for what, wanted, given in [
        ("observation", policy.names["observation"], robot.observation_features),
        ("action", policy.names["action"], robot.action_features),
    ]:
        missing = [name for name in wanted if name not in given]
        if missing:
            raise Stopped(f"the robot's {what} has no {missing[0]}, which the policy needs")
    return float(1.0 / rate)


def control(
    robot: Robot,
    policy: rher.Policy,
    goal: Sequence[float],
    steps: int,
    limits: Limits = Limits(),
    *,
    now: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> int:
    """Acts for an episode, and returns for how many of its steps the arm held.

    Whatever happens, the arm holds and is disconnected before this returns. Where disconnecting
    takes the torque off, the arm must be able to rest there.
    """
    period = check(robot, policy)
    robot.connect()
    try:
        return _act(robot, policy, np.asarray(goal, float), steps, limits, period, now, sleep)
    finally:
        try:
            robot.send_action(dict.fromkeys(policy.names["action"], 0.0))
        finally:
            robot.disconnect()


def _act(
    robot: Robot,
    policy: rher.Policy,
    goal: NDArray[np.float64],
    steps: int,
    limits: Limits,
    period: float,
    now: Callable[[], float],
    sleep: Callable[[float], None],
) -> int:
    begun: rher.Policy | None = None
    names = policy.names["action"]
    last = np.zeros(len(names))
    holds = blind = 0
    due = now()
    for _ in range(steps):
        seen = _read(robot, policy, goal, limits, now)
        if seen is None:
            if blind == limits.patience:
                raise Stopped(f"no usable observation for {blind} periods: late, lost or not finite")
            holds, blind, last = holds + 1, blind + 1, np.zeros(len(names))
        else:
            # With the first observation the policy chooses the order of the objects.
            begun = begun or policy.begin(seen)
            near = np.clip(begun(seen), last - limits.change, last + limits.change)
            blind, last = 0, np.clip(near, -limits.action, limits.action)
        robot.send_action(dict(zip(names, last.tolist())))
        # What a stall has missed is not made up for in a burst.
        due = (now() if now() > due + period else due) + period
        sleep(max(due - now(), 0.0))
    return holds


def _read(
    robot: Robot,
    policy: rher.Policy,
    goal: NDArray[np.float64],
    limits: Limits,
    now: Callable[[], float],
) -> dict[str, NDArray[np.float64]] | None:
    """What the robot sees, as the policy knows it; None where it cannot be used."""
    asked = now()
    try:
        numbers = robot.get_observation()
    except (ConnectionError, TimeoutError):
        return None
    if now() - asked > limits.latest:
        return None
    names = policy.names["observation"]
    objects = [f"{name}.position.{axis}" for name in policy.names["objects"] for axis in "xyz"]
    if not all(math.isfinite(numbers.get(name, math.nan)) for name in names):
        return None
    return {
        "observation": np.array([numbers[name] for name in names]),
        "achieved_goal": np.array([numbers.get(name, 0.0) for name in objects]),
        "desired_goal": goal,
    }
