"""Tests whether an environment of your own has symmetries, on some hundred steps."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from rher._about import about
from rher._arguments import whole
from rher._random_play import Episode, play
from rher.errors import InputError
from rher.symmetry import Image, Mirror, Permutation

__all__ = ["Tested", "symmetries"]

Numbers = NDArray[np.float64]

#: How much worse images may be predicted than what was seen.
WORSE = 1.5
#: Difference of two distributions of which one of a thousand pairs that are equal have a larger one,
#: for one episode; that of Kolmogorov and Smirnov.
UNLIKELY = 1.95 * 2**0.5
#: Share of the variance of a number that no error is smaller than.
CHANCE = 0.05
#: Share of the variance below which a number is not explained, so that nothing can be said of it.
EXPLAINED = 0.3


@dataclass(frozen=True)
class Tested:
    """A symmetry, and what some hundred steps say of it."""

    symmetry: Mirror | Permutation
    #: Of a mirror, how much larger the errors are with which a model predicts the images of steps than
    #: those with which it predicts steps that it has not seen either; about 1 where the mirror holds.
    #: Of a permutation, how far apart the values of a number and of its image are, in units of what one
    #: of a thousand equal ones exceeds; infinite where an object is not where its position is. The
    #: largest of all numbers of an observation.
    ratio: float
    #: Which number of an observation that is.
    worst: int
    #: Numbers of an observation of which this says something.
    explained: list[int]

    @property
    def is_refuted(self) -> bool:
        """Whether the steps speak against it. That they do not is no proof."""
        return self.ratio > (WORSE if isinstance(self.symmetry, Mirror) else 1.0)


def symmetries(
    env: gymnasium.Env[Any, Any],
    *,
    objects: int = 1,
    gripper: slice | None = None,
    mirrors: Sequence[Mirror] | None = None,
    permutations: Sequence[Permutation] = (),
    steps: int = 1000,
) -> list[Tested]:
    """Tests mirrors and permutations on steps of random actions.

    Mirrors: a linear model predicts how a step changes an observation. What it says of the image of a
    step that it has not seen must be as right as what it says of the step itself. This finds a sign that
    is wrong, a number that is missing, or a force in one direction, such as gravity. Permutations: the
    position of each object must go where that of the object goes whose name it takes, and every number
    must have values like those of its image.

    Neither proves a symmetry. Nothing is known of numbers that the model does not explain, of what
    random actions do not reach (objects that are hardly touched, and how they weigh and slide), and of
    walls, or of arms whose reach ends on one side.

    Without ``mirrors``, those perpendicular to each axis are proposed: through where the gripper starts
    on average, with signs by what each number varies with.

    >>> tested = rher.symmetries(env, objects=1)
    >>> good = [one.symmetry for one in tested if not one.is_refuted]

    :param env: the environment, and as in :class:`rher.Trainer` ``objects`` and ``gripper``.
    :param mirrors: the mirrors to test; by default those that are proposed.
    :param permutations: the permutations to test.
    :param steps: environment steps to take, and then to the end of the episode.
    :return: each with the result, mirrors first.
    """
    steps = whole("steps", steps, 100, 2**31 - 1)
    facts = about(env, objects, gripper, None, (), None, None, None, (), ())
    episodes = play(env, steps, facts["episode_steps"])
    axes, first = facts["places"]["axes"], facts["places"]["gripper"]
    if mirrors is None:
        mirrors = [_proposed(episodes, first, axis, axes) for axis in range(axes)]
    model = _Model(episodes)
    return [
        *map(model.test, mirrors),
        *(_exchanged(one, episodes, facts["places"]["objects"], axes) for one in permutations),
    ]


def _exchanged(
    permutation: Permutation, episodes: list[Episode], objects: list[int] | None, axes: int
) -> Tested:
    """Whether objects that trade names are alike, as far as single numbers tell."""
    numbers = range(len(permutation.observation))
    # Both ends of an episode: what is between them is not independent of them.
    seen = np.concatenate([[one.observation[0], one.observation[-1]] for one in episodes])
    images = _applied(permutation.observation, seen)
    if objects is not None and sorted(permutation.order) != list(range(len(objects))):
        raise InputError(
            f"order is {permutation.order}, expected every one of {len(objects)} objects"
        )
    for place, other in enumerate(permutation.order if objects is not None else ()):
        assert objects is not None
        for axis in range(axes):
            number = objects[place] + axis
            if permutation.observation[number] != Image(objects[other] + axis):
                return Tested(permutation, float("inf"), number, list(numbers))
    critical = UNLIKELY / len(episodes) ** 0.5
    ratios = [_apart(seen[:, number], images[:, number]) / critical for number in numbers]
    worst = int(np.argmax(ratios))
    return Tested(permutation, float(ratios[worst]), worst, list(numbers))


def _apart(a: Numbers, b: Numbers) -> float:
    """The largest difference of two distributions."""
    every = np.concatenate([a, b])
    shares = [np.searchsorted(np.sort(one), every, side="right") / len(one) for one in (a, b)]
    return float(np.abs(shares[0] - shares[1]).max())


def _proposed(episodes: list[Episode], gripper: int, axis: int, axes: int) -> Mirror:
    """The mirror perpendicular to an axis, by what the numbers vary with."""
    seen = np.concatenate([one.observation[:-1] for one in episodes])
    change = np.concatenate([np.diff(one.observation, axis=0) for one in episodes])
    actions = np.concatenate([one.actions for one in episodes])
    hand = slice(gripper, gripper + axes)
    center = float(np.mean([one.observation[0][gripper + axis] for one in episodes]))
    # An action belongs to the axis along which the hand moves with it.
    with_action = np.abs(_correlations(actions, change[:, hand]))
    flipped_actions = np.flatnonzero(
        (with_action.argmax(axis=1) == axis) & (with_action.max(axis=1) > 0.2)
    ).tolist()
    # A number belongs to the axis whose places, speeds and differences it varies with.
    achieved = np.concatenate([one.achieved[:-1] for one in episodes])
    achieved = achieved.reshape(len(seen), -1, axes)
    strength = []
    for along in range(axes):
        place, objects = seen[:, [gripper + along]], achieved[:, :, along]
        signals = np.hstack([place, objects, objects - place, change[:, [gripper + along]]])
        strength.append(np.abs(_correlations(seen, signals)).max(axis=1))
    of_axis = np.argmax(strength, axis=0) == axis
    of_axis &= np.max(strength, axis=0) > 0.3
    places = [gripper + axis] + [
        number
        for number in np.flatnonzero(of_axis)
        if number != gripper + axis
        and any(
            np.array_equal(seen[:, number], achieved[:, index, axis])
            for index in range(achieved.shape[1])
        )
    ]
    others = [number for number in np.flatnonzero(of_axis) if number not in places]
    return Mirror.flipping(
        axis=axis,
        center=center,
        observation=seen.shape[1],
        action=actions.shape[1],
        places=[int(number) for number in places],
        others=[int(number) for number in others],
        actions=flipped_actions,
    )


def _correlations(a: Numbers, b: Numbers) -> Numbers:
    """Of every column with every other, 0 where one does not vary."""

    def standard(columns: Numbers) -> Numbers:
        centered = columns - columns.mean(axis=0)
        deviation = centered.std(axis=0)
        return np.asarray(centered / np.where(deviation > 1e-9, deviation, np.inf))

    return np.asarray(standard(a).T @ standard(b) / len(a))


class _Model:
    """How a step changes an observation, linear in the observation and the action."""

    def __init__(self, episodes: list[Episode]) -> None:
        if len(episodes) < 4:
            raise InputError(f"{len(episodes)} episodes are too few: expected steps for at least 4")
        # Steps of one episode resemble each other: what is tested with is of other episodes.
        learned, unseen = _steps(episodes[::2]), _steps(episodes[1::2])
        self._mean, deviation = learned[0].mean(axis=0), learned[0].std(axis=0)
        self._inverse = np.where(deviation > 1e-9, 1.0 / np.maximum(deviation, 1e-9), 0.0)
        self._unseen = unseen
        inputs = self._inputs(learned[0], learned[1])
        ridge = 1e-3 * len(inputs) * np.eye(inputs.shape[1])
        self._weights = np.linalg.solve(inputs.T @ inputs + ridge, inputs.T @ learned[2])
        error = self._error(*unseen)
        variance = (unseen[2] ** 2).mean(axis=0)
        self._explained = np.flatnonzero((variance > 1e-12) & (error < (1 - EXPLAINED) * variance))
        self._error_unseen = error

    def test(self, symmetry: Mirror) -> Tested:
        seen, actions, change = self._unseen
        images = _applied(symmetry.observation, seen)
        moved = _applied(symmetry.observation, seen + change) - images
        actions = _applied(symmetry.action, actions)
        error = self._error(images, actions, moved)
        explained = self._explained
        if len(explained) == 0:
            return Tested(symmetry, 1.0, 0, [])
        # Below a share of what happens, errors are chance.
        scale = CHANCE * (change**2).mean(axis=0)[explained]
        ratios = np.sqrt((error[explained] + scale) / (self._error_unseen[explained] + scale))
        worst = int(np.argmax(ratios))
        return Tested(symmetry, float(ratios[worst]), int(explained[worst]), explained.tolist())

    def _inputs(self, seen: Numbers, actions: Numbers) -> Numbers:
        # What hardly ever moves is many deviations away when it does.
        normal = np.clip((seen - self._mean) * self._inverse, -5.0, 5.0)
        return np.hstack([normal, actions, np.ones((len(seen), 1))])

    def _error(self, seen: Numbers, actions: Numbers, change: Numbers) -> Numbers:
        predicted = self._inputs(seen, actions) @ self._weights
        return np.asarray(((predicted - change) ** 2).mean(axis=0))


def _steps(episodes: list[Episode]) -> tuple[Numbers, Numbers, Numbers]:
    """Observations, actions, and how the observations changed."""
    return (
        np.concatenate([one.observation[:-1] for one in episodes]),
        np.concatenate([one.actions for one in episodes]),
        np.concatenate([np.diff(one.observation, axis=0) for one in episodes]),
    )


def _applied(images: Sequence[Image], rows: Numbers) -> Numbers:
    if len(images) != rows.shape[1]:
        raise InputError(f"a symmetry has {len(images)} numbers, expected {rows.shape[1]}")
    source = [whole("source", image.source, 0, rows.shape[1] - 1) for image in images]
    sign, offset = ([getattr(image, key) for image in images] for key in ("sign", "offset"))
    return np.asarray(rows[:, source] * np.array(sign) + np.array(offset))
