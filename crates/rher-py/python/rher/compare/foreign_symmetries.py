"""Symmetries of the scenes of other packages, number by number."""

from rher import Image, Mirror, Permutation

#: Numbers of a cube of panda-gym: position, Euler angles, velocity, angular velocity. In the mirror
#: y changes its sign, and so do turns about x and z.
_CUBE, _CUBE_FLIPPED = 12, (1, 3, 5, 7, 9, 11)


def panda_mirror(robot: int, cubes: int) -> Mirror:
    """Left and right of panda-gym's robot, which is at y = 0.

    :param robot: numbers of the robot: position and velocity of its hand, and with 7 of them the
        width of its fingers, which an action has a number for.
    """
    starts = [robot + _CUBE * cube for cube in range(cubes)]
    return Mirror.flipping(
        axis=1,
        center=0.0,
        observation=robot + _CUBE * cubes,
        action=robot - 3,
        places=[1, *(start + 1 for start in starts)],
        others=[4, *(start + index for start in starts for index in _CUBE_FLIPPED[1:])],
        actions=[1],
    )


def panda_exchange(robot: int) -> Permutation:
    """The two cubes of panda-gym trade names, although one weighs 2 kg and the other 1."""
    first, second = robot, robot + _CUBE
    order = [*range(robot), *range(second, second + _CUBE), *range(first, first + _CUBE)]
    return Permutation(order=[1, 0], observation=[Image(index) for index in order])


def fetch_mirror() -> Mirror:
    """Left and right of Fetch with one object, whose hand starts at y = 0.7491 m.

    An observation has positions of hand and object, their difference, the two fingers, Euler angles,
    velocity and angular velocity of the object, velocities of hand and fingers.
    """
    mirror = Mirror.flipping(
        axis=1,
        center=0.7491,
        observation=25,
        action=4,
        places=[1, 4],
        others=[7, 11, 13, 15, 17, 19, 21],
        actions=[1],
    )
    images = list(mirror.observation)
    # The fingers are on both sides of the plane.
    for one, other in ((9, 10), (23, 24)):
        images[one], images[other] = Image(other), Image(one)
    return Mirror(mirror.axis, mirror.center, images, mirror.action)
