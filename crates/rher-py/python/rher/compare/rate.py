"""Work for each second of a clock."""

from collections.abc import Callable


def rate(clock: Callable[[], float], seconds: float, work: Callable[[], int]) -> float:
    """What ``work`` does in a second of ``clock``, measured for ``seconds``."""
    done, started = 0, clock()
    while (elapsed := clock() - started) < seconds:
        done += work()
    return done / elapsed
