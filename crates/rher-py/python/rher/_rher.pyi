"""The compiled half of the package; use the package itself."""

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, final

import numpy as np
import numpy.typing as npt

_Observation = dict[str, npt.NDArray[np.float64]]
_Info = dict[str, Any]
_Path = str | os.PathLike[str]
_Beginning = tuple[list[float] | None, list[float] | None, list[float] | None]

__version__: str

def tasks() -> list[str]:
    """Names of the tasks, the simplest first."""

def subtasks(task: str) -> list[str]:
    """What the sub-tasks of a task are called, in their order."""

def main(arguments: Sequence[str], interpreter: _Path, program: Sequence[str]) -> int:
    """Does what a command line says; returns the exit status."""

def run_settings(folder: _Path) -> str:
    """The settings of a run, as JSON."""

def run_state(folder: _Path) -> Literal["running", "solved", "spent", "stopped"]:
    """Whether a run goes on: ``running``, ``solved``, ``spent`` or ``stopped``."""

def export_onnx(policy: Policy | _Path, out: _Path) -> None:
    """Writes a policy, or that in a file, as an ONNX model, and beside it what its numbers are."""

@final
class State:
    """A moment of an episode that an environment can return to; immutable, and can be pickled."""

@final
class Env:
    """An environment of one task."""

    def __new__(cls, task: str, options: str, reward_type: str = "sparse") -> Env: ...
    @property
    def task(self) -> str: ...
    @property
    def options(self) -> str: ...
    @property
    def observation_width(self) -> int: ...
    @property
    def action_width(self) -> int: ...
    @property
    def objects(self) -> int: ...
    @property
    def episode_steps(self) -> int: ...
    @property
    def tolerance(self) -> float: ...
    @property
    def is_seeded(self) -> bool: ...
    def reset(
        self, seed: int | None = None, begun: _Beginning | None = None
    ) -> tuple[_Observation, _Info]: ...
    def step(
        self, action: npt.ArrayLike
    ) -> tuple[_Observation, float, bool, bool, _Info]: ...
    def compute_reward(
        self, achieved: npt.ArrayLike, desired: npt.ArrayLike
    ) -> npt.NDArray[np.float32]: ...
    def get_state(self) -> State: ...
    def set_state(self, state: State) -> tuple[_Observation, _Info]: ...
    def render(self, width: int, height: int) -> npt.NDArray[np.uint8]: ...
    def close(self) -> None: ...

@final
class VectorEnv:
    """Environments of one task that are stepped together without Python's lock."""

    def __new__(cls, made: dict[str, Any]) -> VectorEnv: ...
    @property
    def is_seeded(self) -> bool: ...
    def reset(
        self, seeds: Sequence[int] | None = None, begun: list[_Beginning] | None = None
    ) -> tuple[_Observation, _Info]: ...
    def reset_where(
        self, mask: Sequence[bool], begun: list[_Beginning] | None = None
    ) -> tuple[_Observation, _Info]: ...
    def step(
        self, actions: npt.ArrayLike
    ) -> tuple[
        _Observation,
        npt.NDArray[np.float64],
        npt.NDArray[np.bool_],
        npt.NDArray[np.bool_],
        _Info,
    ]: ...
    def last(self) -> tuple[_Observation, _Info]: ...
    def render(self, width: int, height: int) -> list[npt.NDArray[np.uint8]]: ...
    def get_state(self) -> bytes: ...
    def set_state(self, state: bytes) -> tuple[_Observation, _Info]: ...
    def close(self) -> None: ...

@final
class Policy:
    """A trained policy, with everything it needs to act.

    It acts in environments with observations and goals like those that it was trained in: a policy
    of ``push`` in ``FetchPush-v4``, too. It can be copied and pickled.
    """

    @classmethod
    def load(cls, path: _Path) -> Policy:
        """Reads a policy file, the ``policy.safetensors`` of a run."""

    @classmethod
    def pretrained(cls, task: str) -> Policy:
        """The trained policy that ships with the package for a task, such as ``stack``.

        ``rher play stack`` shows it; ``rher reproduce shipped`` made it.
        """

    def save(self, path: _Path) -> None:
        """Writes a policy file; the file is complete or absent."""

    @property
    def task(self) -> str:
        """Name of the environment that it was trained in."""

    @property
    def objects(self) -> int:
        """Number of objects in its goals."""

    @property
    def observation_width(self) -> int:
        """Length of an observation."""

    @property
    def action_width(self) -> int:
        """Length of an action."""

    @property
    def names(self) -> dict[str, list[str]]:
        """What its numbers are called: lists ``objects``, ``observation`` and ``action``.

        They are empty where nobody knows.
        """

    @property
    def control(self) -> dict[str, Any]:
        """What a controller has to provide so that the policy acts as it did in training.

        ``rate_hz`` is the number of actions in a second, or None, ``frame`` the frame of all
        positions in words; ``observation_units`` and ``action_units`` have a unit for each number,
        such as ``m`` and ``0.05 m/step``, and are empty where nobody knows.
        """

    def __call__(
        self,
        observation: npt.ArrayLike | Mapping[str, npt.ArrayLike],
        goal: npt.ArrayLike | None = None,
    ) -> npt.NDArray[np.float32]:
        """The action for an observation, or the actions for a batch of them.

        :param observation: the dictionary that the environment returns; or its ``observation``
            alone, ``(observation_width,)`` or ``(batch, observation_width)``.
        :param goal: where the objects should be, ``(3 * objects,)`` or ``(batch, 3 * objects)``, in
            meters, or two numbers for each object where it was trained so; by default the
            ``desired_goal`` of the dictionary.
        :return: numbers within -1 and 1, or within the limits of the environment of yours that it
            was trained in, ``(action_width,)`` or ``(batch, action_width)``.
        """

    def predict(
        self,
        observation: npt.ArrayLike | Mapping[str, npt.ArrayLike],
        state: object = None,
        episode_start: object = None,
        deterministic: bool = True,
    ) -> tuple[npt.NDArray[np.float32], None]:
        """As the models of Stable-Baselines3 have it, whose ``evaluate_policy`` takes a policy.

        :return: what the policy returns when it is called, and no state. The other arguments change
            nothing: the policy has neither memory nor chance, and takes objects in their order.
        """

    def begin(
        self,
        observation: npt.ArrayLike | Mapping[str, npt.ArrayLike],
        goal: npt.ArrayLike | None = None,
    ) -> Policy:
        """The policy for the episode that begins here, or for a batch of episodes.

        It places objects in the order that promises most, where the task allows every order; a
        policy that is called without ``begin`` takes them as they are given. Arguments are those of
        a call.
        """

@final
class Trainer:
    """A run and its folder."""

    @classmethod
    def of_task(
        cls,
        task: str,
        arguments: str,
        out: _Path | None,
        workers: int | None,
        from_run: _Path | None,
    ) -> Trainer: ...
    @classmethod
    def of_env(
        cls,
        envs: list[Any],
        about: str,
        arguments: str,
        out: _Path | None,
        workers: int | None,
        from_run: _Path | None,
    ) -> Trainer: ...
    @classmethod
    def resumed(
        cls,
        folder: _Path,
        foreign: tuple[list[Any], str] | None,
        workers: int | None,
        changes: str,
    ) -> Trainer: ...
    @property
    def folder(self) -> os.PathLike[str]: ...
    @property
    def task(self) -> str: ...
    @property
    def end(self) -> tuple[int, float]: ...
    def set_end(self, env_steps: int | None = None, until: float | None = None) -> None: ...
    @property
    def env_steps(self) -> int: ...
    @property
    def policy(self) -> Policy: ...
    def learn(
        self,
        on_event: Callable[[dict[str, Any]], object] | None = None,
        max_wall: float | None = None,
        record_every: int | None = None,
        tensorboard: bool = False,
    ) -> str: ...
    def close(self) -> None: ...
