"""How an environment is called: in a thread that can be given up, or in a process of its own."""

import multiprocessing
import queue
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AsyncVectorEnv, AutoresetMode
from numpy.typing import NDArray

from rher.errors import EnvError

__all__ = ["InProcess", "InThread", "Make"]

#: What makes an environment.
Make = Callable[[], gymnasium.Env[Any, Any]]

#: What ``reset`` returns, and ``step``.
Seen = tuple[Any, dict[str, Any]]
Stepped = tuple[Any, Any, Any, Any, dict[str, Any]]


def _too_long(what: str, timeout: float | None) -> str:
    return f"`{what}` took longer than step_timeout={timeout} seconds"


class InThread:
    """An environment of this process whose calls are given up when they take too long.

    All of them are made by one thread, which a call that does not return keeps forever.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], timeout: float) -> None:
        self._env, self._timeout, self._is_stuck = env, timeout, False
        self._asked: queue.SimpleQueue[Callable[[], Any] | None] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[tuple[bool, Any]] = queue.SimpleQueue()
        threading.Thread(target=self._serve, name="rher environment", daemon=True).start()

    def reset(self, *, seed: int) -> Seen:
        """As that of the environment."""
        answer: Seen = self._call("reset", lambda: self._env.reset(seed=seed))
        return answer

    def step(self, action: NDArray[np.float32]) -> Stepped:
        """As that of the environment."""
        answer: Stepped = self._call("step", lambda: self._env.step(action))
        return answer

    def close(self) -> None:
        """Ends the thread; the environment stays open."""
        self._asked.put(None)

    def _call(self, what: str, work: Callable[[], Any]) -> Any:
        if self._is_stuck:
            raise EnvError("the environment is stuck in an earlier call: make it anew")
        self._asked.put(work)
        try:
            returned, answer = self._answers.get(timeout=self._timeout)
        except queue.Empty:
            self._is_stuck = True
            raise TimeoutError(_too_long(what, self._timeout)) from None
        if not returned:
            raise answer
        return answer

    def _serve(self) -> None:
        while (work := self._asked.get()) is not None:
            try:
                answer = True, work()
            except BaseException as error:
                answer = False, error
            self._answers.put(answer)


class InProcess:
    """An environment in a process of its own: a vector environment of one, without autoreset."""

    def __init__(self, make: Make, timeout: float | None) -> None:
        self._timeout = timeout
        # Without shared memory, into which a number would be written as often as there is room.
        self._envs = AsyncVectorEnv(
            [make], shared_memory=False, autoreset_mode=AutoresetMode.DISABLED
        )
        self.spaces = self._envs.single_observation_space, self._envs.single_action_space

    def reset(self, *, seed: int) -> Seen:
        """As that of the environment."""
        begin = partial(self._envs.reset_async, seed=seed)
        seen, _ = self._call("reset", self._envs.reset_wait, begin)
        return _first(seen), {}

    def step(self, action: NDArray[np.float32]) -> Stepped:
        """As that of the environment; of ``info``, whether it was a success."""
        begin = partial(self._envs.step_async, action[None])
        seen, reward, terminated, truncated, info = self._call("step", self._envs.step_wait, begin)
        said = {key: info[key][0] for key in ("is_success", "success") if key in info}
        return _first(seen), reward[0], terminated[0], truncated[0], said

    def close(self) -> None:
        """Ends the process."""
        if self._envs.closed:
            return
        try:
            self._envs.close(timeout=1)
        except Exception:
            self._end()

    def _call(self, what: str, wait: Callable[..., Any], begin: Callable[[], None]) -> Any:
        """A call that ends the process unless it returns something."""
        if self._envs.closed:
            raise EnvError(
                "the process of the environment ended with an earlier call: make it anew"
            )
        try:
            begin()
            return wait(timeout=self._timeout)
        except multiprocessing.TimeoutError:
            self._end()
            raise TimeoutError(_too_long(what, self._timeout)) from None
        except (EOFError, BrokenPipeError) as error:
            self._end()
            raise EnvError("the process of the environment has ended") from error
        except BaseException:
            self._end()
            raise

    def _end(self) -> None:
        """Ends the process whatever it does: the vector environment would wait for its answer."""
        for process in self._envs.processes:
            process.terminate()
            process.join()
        self._envs.closed = True


def _first(seen: Any) -> dict[str, Any]:
    return {key: numbers[0] for key, numbers in seen.items()}
