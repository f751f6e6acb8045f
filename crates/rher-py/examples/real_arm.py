"""Learning on a real arm, with a person who resets it: a goal environment made of a robot.

The robot has the interface of LeRobot, see ``control_loop.py``. Its numbers here are the position of
the hand, ``hand.x`` to ``hand.z``, and an action is a speed along each axis, as a share of the
fastest. The goal is a place for the hand.
"""

import math
import time
from collections.abc import Callable
from typing import Any, Protocol

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

AXES = ("x", "y", "z")


class Robot(Protocol):
    """What is needed of ``lerobot.robots.Robot``."""

    def connect(self) -> None: ...
    def get_observation(self) -> dict[str, Any]: ...
    def send_action(self, action: dict[str, Any]) -> dict[str, Any]: ...
    def disconnect(self) -> None: ...


class GoHome(Exception):
    """The person wants to stop."""


def ask_on_terminal(question: str) -> None:
    """Waits for Enter, for as long as it takes."""
    if input(f"{question}, then press Enter (q and Enter to stop): ").strip().lower() == "q":
        raise GoHome("the person wants to stop")


class RealArm(gymnasium.Env[dict[str, NDArray[np.float64]], NDArray[np.float32]]):
    """An arm that reaches for places.

    :param robot: it is connected at the first reset, and never waits longer than a period.
    :param corners: opposite corners of the box in which targets are, in meters.
    :param ask: called at each reset, before the arm may move again; it returns when the person is
        ready, and raises an exception to stop.
    :param steps: actions of an episode.
    :param rate: actions in a second.
    :param patience: consecutive periods without a reading after which an episode is cut off.
    """

    distance_threshold = 0.05

    def __init__(
        self,
        robot: Robot,
        corners: tuple[tuple[float, float, float], tuple[float, float, float]],
        ask: Callable[[str], None] = ask_on_terminal,
        *,
        steps: int = 40,
        rate: float = 20.0,
        patience: int = 4,
        now: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.robot, self.corners, self.ask = robot, np.array(corners), ask
        self.steps, self.period, self.patience = steps, 1.0 / rate, patience
        self.now, self.sleep = now, sleep
        self.is_connected = False

        def box(width: int) -> spaces.Space[Any]:
            return spaces.Box(-10.0, 10.0, (width,), np.float64)

        # What was asked of the arm lately is observed, because a late reading does not show it yet.
        self.observation_space: spaces.Space[Any] = spaces.Dict(
            {"observation": box(9), "achieved_goal": box(3), "desired_goal": box(3)}
        )
        self.action_space = spaces.Box(-1.0, 1.0, (3,), np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.float64]], dict[str, Any]]:
        super().reset(seed=seed)
        if not self.is_connected:
            self.robot.connect()
            self.is_connected = True
        self._send(np.zeros(3))
        self.ask("Put the arm where an episode may begin")
        self.target = self.np_random.uniform(*self.corners)
        self.lately = np.zeros((2, 3))
        self.missed = self.taken = 0
        # Nothing is known of the arm yet: there is no episode without a reading.
        self.hand = self._read()
        while self.hand is None:
            self.sleep(self.period)
            self.hand = self._read()
        self.due = self.now()
        return self._seen(), {}

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[dict[str, NDArray[np.float64]], float, bool, bool, dict[str, Any]]:
        if self.now() > self.due + 10 * self.period:
            # The computer was asleep or busy, and what the arm did then was not this action.
            return self._cut_off("nothing was asked of the arm for too long")
        self.taken += 1
        self._send(action)
        self.lately = np.stack([action, self.lately[0]])
        self.due = (self.now() if self.now() > self.due + self.period else self.due) + self.period
        self.sleep(max(self.due - self.now(), 0.0))
        hand = self._read()
        self.missed = 0 if hand is not None else self.missed + 1
        self.hand = self.hand if hand is None else hand
        if self.missed > self.patience:
            return self._cut_off("no reading has come for too long")
        return self._seen(), 0.0, False, self.taken == self.steps, {}

    def close(self) -> None:
        """Holds and disconnects the arm."""
        if self.is_connected:
            self.is_connected = False
            try:
                self._send(np.zeros(3))
            finally:
                self.robot.disconnect()

    def _cut_off(
        self, why: str
    ) -> tuple[dict[str, NDArray[np.float64]], float, bool, bool, dict[str, Any]]:
        """Ends the episode, which is learned from as far as it went."""
        self._send(np.zeros(3))
        return self._seen(), 0.0, False, True, {"cut_off": why}

    def _send(self, action: NDArray[Any]) -> None:
        self.robot.send_action({f"hand.{axis}": float(x) for axis, x in zip(AXES, action)})

    def _read(self) -> NDArray[np.float64] | None:
        try:
            numbers = self.robot.get_observation()
        except (ConnectionError, TimeoutError):
            return None
        hand = np.array([numbers[f"hand.{axis}"] for axis in AXES])
        return hand if all(map(math.isfinite, hand)) else None

    def _seen(self) -> dict[str, NDArray[np.float64]]:
        assert self.hand is not None
        return {
            "observation": np.concatenate([self.hand, *self.lately]),
            "achieved_goal": self.hand.copy(),
            "desired_goal": self.target.copy(),
        }
