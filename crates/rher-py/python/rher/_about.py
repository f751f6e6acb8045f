"""What the learner has to know of an environment, found out and checked before training."""

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from rher._arguments import real, text, whole
from rher.errors import EnvError, InputError
from rher.goals import Tail, checked
from rher.symmetry import Mirror, Permutation, as_json

__all__ = ["KEYS", "about"]

#: The parts of an observation that are used; others may be there.
KEYS = ("observation", "achieved_goal", "desired_goal")

#: The longest episode that a checkpoint has a number for.
MOST_STEPS = 2**30 - 1

#: Steps after which an episode counts as one without an end, where nobody says how long it is.
PATIENCE = 5000


def about(
    env: gymnasium.Env[Any, Any],
    objects: int,
    gripper: slice | None,
    tolerance: float | None,
    tail: Sequence[Tail],
    positions: Sequence[slice] | None,
    episode_steps: int | None,
    name: str | None,
    mirrors: Sequence[Mirror],
    permutations: Sequence[Permutation],
) -> dict[str, Any]:
    """The environment as the compiled half takes it; the parameters are those of ``Trainer``."""
    objects = whole("objects", objects, 0, 3)
    parts, numbers = checked(tail), sum(part.numbers for part in tail)
    if parts and objects == 0:
        raise InputError(
            "objects is 0 and tail is not empty, expected no tail where the goal is a place for the "
            "gripper"
        )
    # The width of a goal may fit positions with a height and without one: beside a tail, they have
    # none only if that of the gripper has none either.
    is_flat = not parts or (
        isinstance(gripper, slice) and len(range(*gripper.indices(MOST_STEPS))) == 2
    )
    axes_allowed = (3, 2) if is_flat else (3,)
    width, axes = _widths(env.observation_space, objects, numbers, axes_allowed)
    has_positions = axes is not None
    axes = axes or 3
    first = _first(gripper, width, axes)
    if has_positions and positions is not None:
        raise InputError("positions is given, but goals have positions: leave it out")
    if not has_positions and positions is None:
        raise InputError(
            f"goals have no positions, expected positions=[slice(...), ...]: {objects} slices of "
            "observation that say where the objects are"
        )
    limits = _limits(env.action_space)
    return {
        "name": _name(env, name),
        "objects": objects,
        "observation": width,
        "action": len(limits["low"]),
        "episode_steps": _episode_steps(env, episode_steps),
        "tolerance": _tolerance(env, tolerance),
        "has_positions": has_positions,
        "tail": parts,
        "places": {
            "gripper": first,
            "objects": _find_objects(env, objects, axes)
            if positions is None
            else _places(positions, objects, width),
            "axes": axes,
            "limits": None if _is_usual(limits) else limits,
            "symmetries": as_json(mirrors, permutations),
        },
    }


def _widths(
    space: gymnasium.Space[Any], objects: int, tail: int, allowed: tuple[int, ...]
) -> tuple[int, int | None]:
    """Numbers of an observation, and of a position; None where goals have no positions."""
    if not isinstance(space, spaces.Dict) or not all(
        isinstance(space.spaces.get(key), spaces.Box) and len(space[key].shape or ()) == 1
        for key in KEYS
    ):
        raise InputError(
            f"the observation space is {space}, expected a Dict with the one-dimensional Boxes "
            f"{', '.join(KEYS)}"
        )
    width, *goals = ((space[key].shape or (0,))[0] for key in KEYS)
    count = max(objects, 1)
    for axes in allowed:
        if goals == [(axes + tail) * count] * 2:
            return width, axes
    if tail and goals == [tail * count] * 2:
        return width, None
    raise InputError(
        f"goals have {goals} numbers, expected {(3 + tail) * count} each for objects={objects}"
        + (f" and a tail of {tail}" if tail else "")
        + (f", or {tail * count} where goals have no positions" if tail else "")
        + f", or {(2 + tail) * count} where positions have no height, of the gripper, too"
    )


def _first(gripper: slice | None, width: int, axes: int) -> int:
    """Where the position of the gripper begins."""
    if gripper is None:
        gripper = slice(0, axes)
    if not isinstance(gripper, slice):
        raise InputError(f"gripper is {gripper!r}, expected a slice such as slice(0, {axes})")
    first, last, step = gripper.indices(width)
    if step != 1 or last - first != axes:
        raise InputError(
            f"gripper is {gripper}, expected {axes} of the {width} numbers observed, as many as a "
            "position has in the goals"
        )
    return first


def _limits(space: gymnasium.Space[Any]) -> dict[str, list[float]]:
    """The lowest and the highest action."""
    if not isinstance(space, spaces.Box) or len(space.shape) != 1:
        raise InputError(f"the action space is {space}, expected a one-dimensional Box")
    if space.dtype not in (np.float32, np.float64):
        raise InputError(f"the action space is {space}, expected one of float32 or float64")
    low, high = space.low, space.high
    if not (np.all(np.isfinite(low)) and np.all(np.isfinite(high))):
        raise InputError(
            f"the action space is {space}, expected finite limits: give it some with "
            "gymnasium.wrappers.TransformAction, whose function may leave the actions as they are"
        )
    # The nearest numbers of 32 bits that are not outside.
    inside_low, inside_high = low.astype(np.float32), high.astype(np.float32)
    too_low, too_high = inside_low < low, inside_high > high
    inside_low[too_low] = np.nextafter(inside_low[too_low], np.float32(np.inf))
    inside_high[too_high] = np.nextafter(inside_high[too_high], np.float32(-np.inf))
    return {"low": inside_low.tolist(), "high": inside_high.tolist()}


def _is_usual(limits: dict[str, list[float]]) -> bool:
    return set(limits["low"]) == {-1.0} and set(limits["high"]) == {1.0}


def _name(env: gymnasium.Env[Any, Any], name: str | None) -> str:
    if name is None:
        name = env.spec.id if env.spec is not None else type(env.unwrapped).__name__
    return text("name", name).replace("/", "-")


def _tolerance(env: gymnasium.Env[Any, Any], tolerance: float | None) -> float:
    if tolerance is None:
        inside = env.unwrapped
        # The second is where panda-gym has it.
        owners = (inside, getattr(inside, "task", None))
        found = (getattr(owner, "distance_threshold", None) for owner in owners)
        tolerance = next((threshold for threshold in found if threshold is not None), 0.05)
    tolerance = real("tolerance", tolerance, 0.0, float(np.finfo(np.float32).max))
    if tolerance == 0:
        raise InputError("tolerance is 0.0, expected a distance in meters")
    return tolerance


def _episode_steps(env: gymnasium.Env[Any, Any], steps: int | None) -> int:
    """The most steps of an episode: as given, as registered, or as found by playing."""
    if steps is None and env.spec is not None:
        steps = env.spec.max_episode_steps
    if steps is None:
        steps = _play_until_truncated(env)
    return whole("episode_steps", steps, 1, MOST_STEPS)


def _play_until_truncated(env: gymnasium.Env[Any, Any]) -> int:
    """Steps of an episode of random actions that ends by its number of steps."""
    env.action_space.seed(0)
    for seed in range(3):
        try:
            env.reset(seed=seed)
            for step in range(PATIENCE):
                _, _, terminated, truncated, _ = env.step(env.action_space.sample())
                if truncated and not terminated:
                    return step + 1
                if terminated:
                    break
        except Exception as error:
            raise EnvError(f"the environment cannot be played: {error}") from error
    raise InputError(
        "episode_steps is not known, and no episode of random actions was truncated: expected the "
        "most steps of an episode"
    )


def _places(positions: Sequence[slice], objects: int, width: int) -> list[int]:
    """Where in observations the positions of the objects begin."""
    places = []
    for position in positions:
        if not isinstance(position, slice):
            raise InputError(f"positions has {position!r}, expected a slice such as slice(3, 6)")
        first, last, step = position.indices(width)
        if step != 1 or last - first != 3:
            raise InputError(
                f"positions has {position}, expected three numbers of the {width} observed"
            )
        places.append(first)
    if len(places) != objects:
        raise InputError(f"positions has {len(places)} slices, expected {objects}")
    return places


def _find_objects(env: gymnasium.Env[Any, Any], objects: int, axes: int) -> list[int] | None:
    """Where in observations the positions of the objects are, if all of them are there.

    They are looked for at the beginning of two episodes. Only calls of a policy without
    ``achieved_goal`` need them.
    """
    places: list[list[int]] = []
    for seed in range(2):
        try:
            seen, _ = env.reset(seed=seed)
        except Exception as error:
            raise EnvError(f"the environment cannot be reset: {error}") from error
        observation = np.asarray(seen["observation"])
        for index, position in enumerate(
            np.reshape(seen["achieved_goal"], (max(objects, 1), -1))[:objects, :axes]
        ):
            windows = np.lib.stride_tricks.sliding_window_view(observation, axes)
            here = np.flatnonzero((windows == position).all(axis=1)).tolist()
            if seed == 0:
                places.append(here)
            else:
                places[index] = [place for place in places[index] if place in here]
    return [place[0] for place in places] if objects and all(places) else None
