"""What will not work in an environment of your own, before any of it is trained on."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from rher._about import about
from rher._arguments import whole
from rher._random_play import Episode, play

__all__ = ["Problem", "check"]

#: Share of goals that may be reached where an episode begins.
SOLVED = 0.5
#: Share of rewards that may differ from those that are learned from.
DIFFERENT = 0.005
#: Meters that an object may move without being touched.
STILL = 1e-4


@dataclass(frozen=True)
class Problem:
    """Something that will not work, or not well."""

    #: What kind of problem it is, such as ``gripper``.
    kind: str
    #: What was seen, and what to do.
    message: str

    def __str__(self) -> str:
        return f"{self.kind}: {self.message}"


def check(
    env: gymnasium.Env[Any, Any],
    *,
    objects: int = 1,
    gripper: slice | None = None,
    tolerance: float | None = None,
    episode_steps: int | None = None,
    steps: int = 500,
) -> list[Problem]:
    """Looks at some hundred steps of random actions for what will not work in training.

    >>> for problem in rher.check(gymnasium.make("FetchPush-v4"), objects=1):
    ...     print(problem)

    It finds rewards that differ from ``compute_reward`` or from what is learned from (kinds
    ``reward``, ``tolerance``), goals that are reached where episodes begin (``solved``) or that change
    during an episode (``goal``), objects that random actions do not move (``still``), and a ``gripper``
    that is no position or that of something else (``gripper``). That nothing is found does not say
    that an environment can be learned.

    :param env: the environment, and as in :class:`rher.Trainer` all that follows but
    :param steps: environment steps to take, and then to the end of the episode.
    :return: the problems; none if nothing was found.
    :raise InputError: if the environment would be refused.
    :raise EnvError: if it cannot be played.
    """
    steps = whole("steps", steps, 1, 2**31 - 1)
    facts = about(env, objects, gripper, tolerance, (), None, episode_steps, None, (), ())
    episodes = play(env, steps, facts["episode_steps"])
    axes, first = facts["places"]["axes"], facts["places"]["gripper"]
    scene = _Scene(episodes, facts["objects"], axes, facts["tolerance"], slice(first, first + axes))
    return [
        *_of_goals(scene),
        *_of_objects(scene),
        *_of_gripper(scene),
        *_of_rewards(env, scene),
    ]


@dataclass(frozen=True)
class _Scene:
    episodes: list[Episode]
    objects: int
    axes: int
    tolerance: float
    gripper: slice

    def hands(self, episode: Episode) -> NDArray[Any]:
        """``[T + 1, axes]``."""
        return np.array(episode.observation)[:, self.gripper]

    def places(self, goals: list[NDArray[Any]]) -> NDArray[Any]:
        """``[..., objects, axes]``."""
        return np.array(goals).reshape(len(goals), -1, self.axes)

    def is_met(self, achieved: NDArray[Any], desired: NDArray[Any]) -> NDArray[Any]:
        """As in training, for places ``[..., objects, axes]``."""
        apart = np.linalg.norm(achieved - desired, axis=-1)
        return np.asarray(np.all(apart <= self.tolerance, axis=-1))


def _of_goals(scene: _Scene) -> Iterator[Problem]:
    changing = [
        episode for episode in scene.episodes if np.ptp(np.array(episode.desired), axis=0).any()
    ]
    if changing:
        yield Problem(
            "goal",
            f"desired_goal changed during {len(changing)} of {len(scene.episodes)} episodes; that with "
            "which an episode begins is learned from, so end the episode before it changes",
        )
    begun = [
        scene.is_met(scene.places(one.achieved[:1]), scene.places(one.desired[:1]))[0]
        for one in scene.episodes
    ]
    if np.mean(begun) > SOLVED:
        yield Problem(
            "solved",
            f"{sum(begun)} of {len(begun)} goals were reached where the episode began, within "
            f"{scene.tolerance}; a smaller tolerance or goals that are further away leave something "
            "to learn",
        )


def _of_objects(scene: _Scene) -> Iterator[Problem]:
    for index in range(scene.objects):
        ways = [scene.places(one.achieved)[:, index] for one in scene.episodes]
        moved = [np.linalg.norm(way - way[0], axis=1).max() > STILL for way in ways]
        if not any(moved):
            taken = sum(len(one.actions) for one in scene.episodes)
            yield Problem(
                "still",
                f"object {index + 1} moved in none of {len(ways)} episodes, {taken} steps of random "
                "actions; hindsight learns from what was moved by chance, so let some episodes begin "
                "near the object or with it in the gripper",
            )


def _of_gripper(scene: _Scene) -> Iterator[Problem]:
    hands = [scene.hands(one) for one in scene.episodes]
    achieved = [scene.places(one.achieved) for one in scene.episodes]
    if not any(np.ptp(way, axis=0).any() for way in hands):
        yield Problem(
            "gripper",
            f"the numbers {scene.gripper.start} to {scene.gripper.stop - 1} of observation did not "
            "change with random actions: are they the position of what the actions move?",
        )
        return
    if scene.objects == 0:
        apart = max(
            np.abs(hand - place[:, 0]).max() for hand, place in zip(hands, achieved, strict=True)
        )
        if apart > scene.tolerance:
            yield Problem(
                "gripper",
                f"it is up to {apart:.3g} away from achieved_goal, which with objects=0 is its place",
            )
        return
    for index in range(scene.objects):
        if all(
            np.array_equal(hand, place[:, index])
            for hand, place in zip(hands, achieved, strict=True)
        ):
            yield Problem("gripper", f"it is always where object {index + 1} is: it is that object")
            return
    everything = np.concatenate(
        [place.reshape(-1, scene.axes) for place in achieved]
        + [scene.places(one.desired).reshape(-1, scene.axes) for one in scene.episodes]
    )
    low, high = everything.min(axis=0), everything.max(axis=0)
    size = max(float(np.max(high - low)), scene.tolerance)
    outside = np.maximum(np.maximum(low - (every := np.concatenate(hands)), every - high), 0.0)
    nearest = float(np.linalg.norm(outside, axis=1).min())
    if nearest > 3.0 * size:
        yield Problem(
            "gripper",
            f"it was never nearer than {nearest:.3g} to where objects and goals are, which is a region of "
            f"{size:.3g}: positions must be in one frame and in the same unit, and no speeds",
        )


def _of_rewards(env: gymnasium.Env[Any, Any], scene: _Scene) -> Iterator[Problem]:
    compute = getattr(env.unwrapped, "compute_reward", None)
    if not callable(compute):
        return
    rewards: list[float] = []
    different = 0
    for one in scene.episodes:
        frames = zip(one.achieved[1:], one.desired[1:], one.infos, one.rewards, strict=True)
        for achieved, desired, info, reward in frames:
            rewards.append(float(compute(achieved, desired, info)))
            different += abs(rewards[-1] - reward) > 1e-6
    if different > DIFFERENT * len(rewards):
        yield Problem(
            "reward",
            f"{different} of {len(rewards)} rewards differ from compute_reward(achieved_goal, "
            "desired_goal, info); hindsight asks for rewards that follow from the two goals alone",
        )
    yield from _of_tolerance(compute, scene)


def _of_tolerance(compute: Any, scene: _Scene) -> Iterator[Problem]:
    """Compares with the reward that is learned from, at places around the goals."""
    rng = np.random.default_rng(1)
    goals = np.array([one.desired[0] for one in scene.episodes])
    goals = goals[rng.integers(len(goals), size=400)]
    positions = scene.places(list(goals))
    best = float(compute(goals[0], goals[0], {}))
    away = rng.normal(size=positions.shape)
    away /= np.linalg.norm(away, axis=-1, keepdims=True)
    # Some objects stay in their places, and the others are up to two tolerances away.
    far = rng.uniform(0.0, 2.0, positions.shape[:2]) * (rng.random(positions.shape[:2]) < 0.7)
    achieved = positions + away * (far * scene.tolerance)[..., None]
    rows = zip(achieved.reshape(goals.shape), goals, strict=True)
    theirs = np.array([float(compute(row, goal, {})) for row, goal in rows])
    if len(np.unique(theirs)) > 2:
        yield Problem(
            "reward",
            "compute_reward has more than two values; it is not used: the reward that is learned from "
            f"is 0 where every object is within {scene.tolerance} of its place, and -1 elsewhere",
        )
        return
    reached = theirs == best
    ours = scene.is_met(achieved, positions)
    if np.mean(reached != ours) <= DIFFERENT:
        return
    apart = np.linalg.norm(achieved - positions, axis=-1)
    hints = {"the tolerance of every object": apart.max(axis=1)}
    if scene.objects > 1:
        hints["the distance of all goals together"] = np.linalg.norm(apart, axis=1)
    advice = "no distance explains it: its rewards cannot be learned"
    for what, distance in hints.items():
        within = distance[reached].max(initial=0.0)
        if not np.any(distance[~reached] < within):
            beyond = distance[~reached].min(initial=np.inf)
            per_object = (
                within if scene.objects < 2 or "every" in what else within / scene.objects**0.5
            )
            advice = (
                f"it is {within:.3g} to {beyond:.3g} as {what}: pass tolerance={per_object:.3g}"
            )
            break
    yield Problem(
        "tolerance",
        f"compute_reward differs in {np.mean(reached != ours):.0%} of the places near goals from the reward "
        f"that is learned from, with tolerance={scene.tolerance}; {advice}",
    )
