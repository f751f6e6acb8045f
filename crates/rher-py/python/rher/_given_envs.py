"""The environments that a trainer was given, in any of the forms that it takes."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeAlias

import gymnasium
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv, VectorEnv

from rher._calls import InProcess, InThread, Make
from rher.errors import EnvError, InputError

__all__ = ["Given", "GivenEnvs"]

#: An environment, several of them, or what makes each of several.
Given: TypeAlias = "gymnasium.Env[Any, Any] | VectorEnv[Any, Any, Any] | Sequence[Callable[[], gymnasium.Env[Any, Any]]]"


class GivenEnvs:
    """Environments that are played side by side.

    :ivar first: one of them, or one like them, to look at before training.
    :ivar envs: what is trained on: everything that has ``reset`` and ``step``.
    """

    def __init__(self, given: Given, timeout: float | None) -> None:
        here, makes = _here_or_made(given)
        self._owned: list[InThread | InProcess] = []
        self._probe: gymnasium.Env[Any, Any] | None = None
        if makes:
            self.first = self._probe = _made(makes[0])
            try:
                self._make_processes(makes, timeout)
            except BaseException:
                self.close()
                raise
        else:
            self.first = here[0]
            if timeout is not None:
                self._owned = [InThread(env, timeout) for env in here]
        self.envs: list[Any] = list(self._owned or here)

    def _make_processes(self, makes: list[Make], timeout: float | None) -> None:
        spaces = {repr((self.first.observation_space, self.first.action_space))}
        for make in makes:
            env = _in_process(make, timeout)
            self._owned.append(env)
            spaces.add(repr(env.spaces))
        if len(spaces) > 1:
            raise InputError(f"the environments differ: {' and '.join(sorted(spaces))}")

    def looked(self) -> None:
        """Closes what was made to be looked at only."""
        if self._probe is not None:
            self._probe.close()
            self._probe = None

    def close(self) -> None:
        """Ends processes and threads; environments that were given stay open."""
        self.looked()
        for env in self._owned:
            env.close()


def _here_or_made(given: Given) -> tuple[list[gymnasium.Env[Any, Any]], list[Make]]:
    """Environments of this process, or else what makes those of others."""
    if isinstance(given, gymnasium.Env):
        return [given], []
    if isinstance(given, SyncVectorEnv):
        return list(given.envs), []
    if isinstance(given, AsyncVectorEnv):
        return [], list(given.env_fns)
    if isinstance(given, VectorEnv):
        return [], _of_registered(given)
    makes = list(given) if isinstance(given, Sequence) else []
    if not makes or not all(callable(make) for make in makes):
        raise InputError(
            f"env is {given!r}, expected an environment of Gymnasium, a vector environment, or a list "
            "of functions that make one environment each"
        )
    return [], makes


def _of_registered(given: VectorEnv[Any, Any, Any]) -> list[Make]:
    """What makes the environments that a vector environment has the name of."""
    spec = given.spec
    if spec is None or given.unwrapped is not given:
        raise InputError(
            f"env is {given}, which does not say how each of its environments is made: expected a "
            "list of functions that make one environment each, with its wrappers"
        )
    of_vector = {"num_envs", "vectorization_mode", "vector_kwargs", "wrappers"}
    kwargs = {key: value for key, value in spec.kwargs.items() if key not in of_vector}
    return [partial(gymnasium.make, spec.id, **kwargs)] * given.num_envs


def _made(make: Make) -> gymnasium.Env[Any, Any]:
    try:
        env = make()
    except Exception as error:
        raise EnvError(f"the environment cannot be made: {error}") from error
    if not isinstance(env, gymnasium.Env):
        raise InputError(f"the first function made {env!r}, expected an environment of Gymnasium")
    return env


def _in_process(make: Make, timeout: float | None) -> InProcess:
    try:
        return InProcess(make, timeout)
    except Exception as error:
        raise EnvError(f"the environment cannot be made in its process: {error}") from error
