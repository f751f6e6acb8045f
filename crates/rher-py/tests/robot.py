"""A robot with the interface of LeRobot, simulated by a task of this package in simulated time."""

import gymnasium
import numpy as np

import rher


class SimulatedRobot:
    """A robot whose numbers have the names of the task's policy."""

    def __init__(self, name="rher/Push-v0", seed=0, fault=None):
        self.env = gymnasium.make(name)
        self.names = rher.Policy.pretrained(rher.IDS[name]).names
        self.seed, self.fault = seed, fault
        self.is_connected = False
        self.readings, self.sent, self.clock = 0, [], 0.0

    @property
    def observation_features(self):
        return dict.fromkeys(self.names["observation"], float)

    @property
    def action_features(self):
        return dict.fromkeys(self.names["action"], float)

    def connect(self, calibrate=True):
        self.is_connected = True
        self.seen, self.info = self.env.reset(seed=self.seed)
        self.readings = 0

    def get_observation(self):
        assert self.is_connected
        self.readings += 1
        numbers = dict(zip(self.names["observation"], self.seen["observation"].tolist()))
        if self.fault is not None:
            self.fault(self, numbers)
        return numbers

    def send_action(self, action):
        assert self.is_connected
        self.sent.append((self.clock, list(action.values())))
        row = np.array([action[name] for name in self.names["action"]], np.float32)
        self.seen, *_, self.info = self.env.step(row)
        return action

    def disconnect(self):
        self.is_connected = False

    # The clock of the robot.

    def now(self):
        return self.clock

    def sleep(self, seconds):
        self.clock += seconds
