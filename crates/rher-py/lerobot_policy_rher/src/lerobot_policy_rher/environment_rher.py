"""Goal environments of Gymnasium in LeRobot's evaluation."""

import importlib
from dataclasses import dataclass
from typing import Any

import gymnasium
from gymnasium.vector import AutoresetMode
from lerobot.envs import EnvConfig
from lerobot_policy_rher.configuration_rher import KEYS, features_of

__all__ = ["RherEnvConfig"]


@EnvConfig.register_subclass("rher")
@dataclass
class RherEnvConfig(EnvConfig):
    """An environment of rher, or another goal environment that Gymnasium makes."""

    #: Its id.
    task: str | None = "rher/Push-v0"
    #: What is imported so that Gymnasium knows the id, such as ``gymnasium_robotics``.
    package: str = "rher"

    def __post_init__(self) -> None:
        importlib.import_module(self.package)
        env = gymnasium.make(self.task)
        spaces, action = env.observation_space, env.action_space
        env.close()
        if not isinstance(spaces, gymnasium.spaces.Dict) or not set(KEYS) <= set(spaces.spaces):
            raise ValueError(
                f"the observations of `{self.task}` are {spaces}, expected a dictionary with "
                f"{', '.join(KEYS)}"
            )
        widths = [spaces[key].shape[0] for key in ("observation", "desired_goal")]
        inputs, outputs = features_of(*widths, action.shape[0])
        self.features = {**inputs, **outputs}
        self.features_map = {key: key for key in self.features}
        self.fps = env.metadata.get("render_fps", self.fps)

    @property
    def package_name(self) -> str:
        """What makes the id known."""
        return self.package

    @property
    def gym_id(self) -> str:
        """The id."""
        return self.task

    @property
    def gym_kwargs(self) -> dict[str, Any]:
        """What an environment is made with."""
        return {"render_mode": "rgb_array"}

    def create_envs(
        self, n_envs: int, use_async_envs: bool = False
    ) -> dict[str, dict[int, gymnasium.vector.VectorEnv]]:
        """The environments that LeRobot steps together."""
        is_async = use_async_envs and n_envs > 1
        kind = gymnasium.vector.AsyncVectorEnv if is_async else gymnasium.vector.SyncVectorEnv
        envs = kind([self._make] * n_envs, autoreset_mode=AutoresetMode.SAME_STEP)
        return {self.type: {0: envs}}

    def _make(self) -> gymnasium.Env:
        importlib.import_module(self.package)
        return AtItsEnd(gymnasium.make(self.task, **self.gym_kwargs), self.task)


class AtItsEnd(gymnasium.Wrapper):
    """Says whether an episode succeeded at its end alone, as success is defined here: LeRobot counts
    one in which any step was successful. Options that LeRobot resets with go no further.
    """

    def __init__(self, env: gymnasium.Env, task: str) -> None:
        super().__init__(env)
        #: What LeRobot tells a policy to do.
        self.task_description = task

    def reset(self, *, seed=None, options=None):
        """Starts an episode."""
        return self.env.reset(seed=seed)

    def step(self, action):
        """Carries out an action."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        if not (terminated or truncated):
            info = {key: value for key, value in info.items() if key != "is_success"}
        return observation, reward, terminated, truncated, info
