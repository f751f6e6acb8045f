"""Symmetries of an environment of your own: every episode is then also its images."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rher._arguments import real, whole
from rher.errors import InputError

__all__ = ["Image", "Mirror", "Permutation"]

#: The largest number of 32 bits.
LARGEST = 3.0e38


@dataclass(frozen=True)
class Image:
    """A number of an observation or an action under a symmetry: ``sign * original[source] + offset``."""

    source: int
    sign: float = 1.0
    offset: float = 0.0

    def _as_json(self) -> dict[str, Any]:
        return {
            "from": whole("source", self.source, 0, 2**31 - 1),
            "sign": real("sign", self.sign, -1.0, 1.0),
            "offset": real("offset", self.offset, -LARGEST, LARGEST),
        }


@dataclass(frozen=True)
class Mirror:
    """A plane of symmetry, perpendicular to an axis: every episode has a mirror image that obeys the
    same physics.

    >>> # Observations are the x and y of a hand and of a block; actions move the hand.
    >>> rher.Mirror.flipping(axis=1, center=0.75, observation=4, action=2, places=[1, 3], actions=[1])
    """

    #: The axis that is flipped: 0, 1 or 2.
    axis: int
    #: Where the plane crosses it, in meters.
    center: float
    #: One for each number of an observation.
    observation: Sequence[Image]
    #: One for each number of an action, in which -1 and 1 are the limits of the environment.
    action: Sequence[Image]

    @classmethod
    def flipping(
        cls,
        *,
        axis: int,
        center: float,
        observation: int,
        action: int,
        places: Sequence[int],
        others: Sequence[int] = (),
        actions: Sequence[int],
    ) -> "Mirror":
        """The mirror that leaves every number in its place.

        :param observation: numbers of an observation.
        :param action: numbers of an action.
        :param places: which numbers of an observation are coordinates along the axis.
        :param others: which others change their sign, such as speeds along it.
        :param actions: which numbers of an action change their sign.
        """

        def image(index: int) -> Image:
            if index in places:
                return Image(index, -1.0, 2.0 * center)
            return Image(index, -1.0 if index in others else 1.0)

        named = [("places", places, observation), ("others", others, observation)]
        for name, indices, width in [*named, ("actions", actions, action)]:
            for index in indices:
                whole(f"a number of {name}", index, 0, width - 1)
        return cls(
            axis,
            center,
            [image(index) for index in range(observation)],
            [Image(index, -1.0 if index in actions else 1.0) for index in range(action)],
        )


@dataclass(frozen=True)
class Permutation:
    """Interchangeable objects in another order; actions stay the same.

    >>> # Observations are the x of a hand and of two blocks, which trade names.
    >>> rher.Permutation(order=[1, 0], observation=[rher.Image(0), rher.Image(2), rher.Image(1)])
    """

    #: For each place in the order, which object comes there, counted from 0.
    order: Sequence[int]
    #: One for each number of an observation.
    observation: Sequence[Image]


def as_json(mirrors: Sequence[Mirror], permutations: Sequence[Permutation]) -> dict[str, Any]:
    """Symmetries as the compiled half takes them, which checks that they are some."""
    for name, kind, given in (
        ("mirrors", Mirror, mirrors),
        ("permutations", Permutation, permutations),
    ):
        if not all(isinstance(one, kind) for one in given):
            raise InputError(f"{name} is {given!r}, expected rher.{kind.__name__}s")
    return {
        "mirrors": [
            {
                "axis": whole("axis", mirror.axis, 0, 2),
                "center": real("center", mirror.center, -LARGEST, LARGEST),
                "observation": [image._as_json() for image in mirror.observation],
                "action": [image._as_json() for image in mirror.action],
            }
            for mirror in mirrors
        ],
        "permutations": [
            {
                "order": [whole("order", place, 0, 2) for place in permutation.order],
                "observation": [image._as_json() for image in permutation.observation],
            }
            for permutation in permutations
        ],
    }
