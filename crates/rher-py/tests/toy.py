"""Small goal environments in Python: a hand in a box that carries what it touches."""

from collections import deque

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


class Ending(Carry):
    """Ends once the objects are in their places, or, as a failure, once the hand is in a corner.

    Episodes of every third seed are cut off before their last step.
    """

    def __init__(self, objects=1, says_so=True):
        super().__init__(objects)
        self.says_so, self.cut = says_so, False
        #: Steps of the latest episodes, and how they ended.
        self.ends = deque(maxlen=100)

    def reset(self, *, seed=None, options=None):
        self.cut = seed is not None and seed % 3 == 0
        return super().reset(seed=seed, options=options)

    def step(self, action):
        seen, reward, terminated, truncated, info = super().step(action)
        apart = (seen["achieved_goal"] - seen["desired_goal"]).reshape(-1, 3)
        success = bool(np.all(np.linalg.norm(apart, axis=1) <= self.distance_threshold))
        terminated = success or bool(np.all(self.hand[:2] == 1))
        truncated = truncated or self.cut and self.steps == STEPS - 5
        if terminated or truncated:
            self.ends.append((self.steps, "solved" if success else "failed" if terminated else "cut"))
        return seen, reward, terminated, truncated, info | ({"is_success": success} if self.says_so else {})


class Flat(gymnasium.ObservationWrapper):
    """Positions without a height, in numbers of 32 bits, beside something that nobody uses."""

    def __init__(self, env):
        super().__init__(env)
        spaces_of = env.observation_space.spaces
        width = {key: space.shape[0] // 3 * 2 for key, space in spaces_of.items()}
        box = {key: spaces.Box(-2.0, 2.0, (n,), np.float32) for key, n in width.items()}
        self.observation_space = spaces.Dict(box | {"camera": spaces.Box(0, 255, (4, 4), np.uint8)})

    def observation(self, observation):
        flat = {
            key: numbers.reshape(-1, 3)[:, :2].ravel().astype(np.float32)
            for key, numbers in observation.items()
        }
        return flat | {"camera": np.zeros((4, 4), np.uint8)}
