"""An arm that is slow to answer, simulated in simulated time: nothing sleeps."""

import numpy as np

#: Seconds of simulation between two looks at the commands.
TICK = 0.005
#: Meters a second of an action of 1.
SPEED = 0.8


class SlowArm:
    """An arm whose readings are 80 ms old, and some of whose messages are lost.

    A command moves the hand until the next one, or until the arm's own watchdog stops it.
    """

    def __init__(self, seed=0, late=0.08, lost=0.1, watchdog=0.3):
        self.random = np.random.default_rng(seed)
        self.late, self.lost, self.watchdog = late, lost, watchdog
        self.time = 0.0
        self.hand = np.full(3, 0.5)
        self.speed, self.heard = np.zeros(3), 0.0
        #: Where the hand was, tick by tick.
        self.past = [self.hand.copy()]
        self.moves = 0
        self.is_connected = False

    def connect(self):
        self.is_connected = True

    def disconnect(self):
        self.is_connected = False

    def get_observation(self):
        assert self.is_connected
        if self.random.random() < self.lost:
            raise ConnectionError("the reading was lost")
        then = self.past[max(len(self.past) - 1 - round(self.late / TICK), 0)]
        return {f"hand.{axis}": x for axis, x in zip("xyz", then.tolist())}

    def send_action(self, action):
        assert self.is_connected
        numbers = np.array(list(action.values()))
        self.moves += bool(numbers.any())
        # A command to hold is repeated until it arrives.
        if not numbers.any() or self.random.random() >= self.lost:
            self.speed, self.heard = SPEED * numbers, self.time
        return action

    # The clock of the arm, which a test can move.

    def now(self):
        return self.time

    def sleep(self, seconds):
        for _ in range(round(seconds / TICK)):
            self.time += TICK
            if self.time - self.heard > self.watchdog:
                self.speed = np.zeros(3)
            self.hand = np.clip(self.hand + TICK * self.speed, 0.0, 1.0)
            self.past.append(self.hand.copy())
