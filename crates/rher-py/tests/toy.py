"""Small goal environments in Python: a hand in a box that carries what it touches."""

import gymnasium
import numpy as np
from gymnasium import spaces

STEPS = 25


class Carry(gymnasium.Env):
    """A hand, and ``objects`` that it carries once it is near them."""

    distance_threshold = 0.1

    def __init__(self, objects=1):
        self.objects = objects
        box = lambda width: spaces.Box(-2.0, 2.0, (width,), np.float64)  # noqa: E731
        goal = 3 * max(objects, 1)
        self.observation_space = spaces.Dict(
            {
                "observation": box(3 + 3 * objects),
                "achieved_goal": box(goal),
                "desired_goal": box(goal),
            }
        )
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)

    def anywhere(self, count):
        return np.pad(self.np_random.uniform(0, 1, (count, 2)), ((0, 0), (0, 1)))

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.hand = self.anywhere(1)[0]
        self.things = self.anywhere(self.objects)
        self.goal = self.anywhere(max(self.objects, 1))
        self.steps = 0
        return self.seen(), {}

    def step(self, action):
        assert self.action_space.contains(action)
        self.steps += 1
        held = np.flatnonzero(np.linalg.norm(self.things - self.hand, axis=1) < 0.12)
        self.hand[:2] = np.clip(self.hand[:2] + 0.1 * action, 0, 1)
        self.things[held[:1]] = self.hand
        return self.seen(), 0.0, False, self.steps == STEPS, {}

    def seen(self):
        achieved = self.things if self.objects else self.hand
        return {
            "observation": np.concatenate([self.hand, self.things.ravel()]),
            "achieved_goal": achieved.ravel().copy(),
            "desired_goal": self.goal.ravel().copy(),
        }
