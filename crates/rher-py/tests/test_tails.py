"""Goals that say more of an object than where it should be, in environments written in Python."""

import gymnasium
import numpy as np
import pytest
import rher
import rher.onnx
from gymnasium import spaces

STEPS = 20


class Knob(gymnasium.Env):
    """A hand on a line, and ``count`` knobs that it turns while it is beside them.

    A goal is an angle for each knob, and its place if ``places`` says so; or, with ``quaternion``, an
    orientation and nothing else.
    """

    def __init__(self, count=1, places=True, quaternion=False):
        self.count, self.places, self.quaternion = count, places, quaternion
        box = lambda width: spaces.Box(-10.0, 10.0, (width,), np.float64)  # noqa: E731
        goal = count * ((3 if places else 0) + (4 if quaternion else 1))
        self.observation_space = spaces.Dict(
            {
                "observation": box(3 + 5 * count),
                "achieved_goal": box(goal),
                "desired_goal": box(goal),
            }
        )
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.steps = 0
        self.hand = 0.0
        self.knobs = np.pad(self.np_random.uniform(-0.5, 0.5, (self.count, 1)), ((0, 0), (0, 2)))
        self.turned, self.wanted = self.np_random.uniform(-np.pi, np.pi, (2, self.count))
        return self.seen(), {}

    def step(self, action):
        self.steps += 1
        self.hand = np.clip(self.hand + 0.15 * action[0], -0.5, 0.5)
        self.turned[np.abs(self.knobs[:, 0] - self.hand) < 0.1] += 0.5 * action[1]
        return self.seen(), 0.0, False, self.steps == STEPS, {}

    def goal(self, angles):
        if self.quaternion:
            half = angles[:, None] / 2
            tail = np.concatenate([np.zeros((self.count, 2)), np.sin(half), np.cos(half)], axis=1)
            # Either sign is the same orientation.
            tail *= self.np_random.choice([-1.0, 1.0], (self.count, 1))
        else:
            tail = angles[:, None]
        return np.concatenate(([self.knobs] if self.places else []) + [tail], axis=1).ravel()

    def seen(self):
        around = np.stack([np.cos(self.turned), np.sin(self.turned)], axis=1)
        return {
            "observation": np.concatenate([[self.hand, 0, 0], self.knobs.ravel(), around.ravel()]),
            "achieved_goal": self.goal(self.turned),
            "desired_goal": self.goal(self.wanted),
        }

    def is_turned(self, tolerance):
        return np.all(np.cos(self.turned - self.wanted) >= np.cos(tolerance))


ANGLE = [rher.Angle("yaw", 0.3)]
ORIENTATION = [rher.Quaternion("orientation", 0.3)]


def trainer(env, out, **arguments):
    positions = None if env.places else [slice(3 + 3 * i, 6 + 3 * i) for i in range(env.count)]
    given = {"out": out, "episode_steps": STEPS, "objects": env.count, "tolerance": 0.1}
    return rher.Trainer(env, **given | {"positions": positions} | arguments)


@pytest.mark.parametrize(
    ("places", "quaternion"), [(True, False), (False, True)], ids=["angle", "orientation"]
)
def test_it_learns_to_turn(places, quaternion, out):
    sizes = {
        "agent.hidden": [64, 64],
        "evaluation.every_episodes": 50,
        "evaluation.episodes": 50,
    }
    env = Knob(places=places, quaternion=quaternion)
    tail = ORIENTATION if quaternion else ANGLE
    fresh = trainer(env, out, tail=tail, set=sizes, workers=1)
    run = fresh.learn(env_steps=20_000, until=0.8)
    assert run.metrics["success_final"].max() >= 0.8
    ends = []
    for seed in range(20):
        seen, _ = env.reset(seed=1000 + seed)
        for _ in range(STEPS):
            seen, *_ = env.step(fresh.policy(seen))
        ends.append(env.is_turned(0.3))
    assert np.mean(ends) >= 0.6


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("places", [True, False])
def test_runs_and_policies_keep_their_tails(count, places, tiny, tmp_path):
    def fresh(out, **arguments):
        env = Knob(count, places, quaternion=True)
        return trainer(env, tmp_path / out, tail=ORIENTATION, **arguments)

    whole = fresh("whole", set=tiny).learn(env_steps=20 * STEPS)
    fresh("parts", set=tiny).learn(env_steps=10 * STEPS)
    parts = fresh("unused", resume=tmp_path / "parts").learn(env_steps=20 * STEPS)
    for key in ("success_final", "critic_loss", "final_distance"):
        assert np.array_equal(parts.metrics[key], whole.metrics[key]), key

    policy = rher.Policy.load(whole.path / "policy.safetensors")
    assert policy.names["tail"] == ["orientation"]
    seen, _ = Knob(count, places, quaternion=True).reset(seed=3)
    action = policy(seen)
    same = seen | {"achieved_goal": seen["achieved_goal"].copy()}
    width = len(same["achieved_goal"]) // count
    for first in range(width - 4, count * width, width):
        same["achieved_goal"][first : first + 4] *= -1
    assert np.allclose(policy(same), action, atol=1e-6)
    with pytest.raises(rher.InputError, match="expected the dictionary"):
        policy(seen["observation"], seen["desired_goal"])
    with pytest.raises(rher.InputError, match=f"expected .*{count * width}"):
        policy(seen["observation"], seen["desired_goal"][:-1])
    with pytest.raises(rher.PolicyError, match="say more of objects than where they should be"):
        rher.onnx.export(whole, whole.path / "policy.onnx")
    # The run is of goals with an orientation.
    other = Knob(count, places=True, quaternion=False)
    with pytest.raises(rher.RherError, match="goals of"):
        trainer(other, None, tail=ANGLE, resume=tmp_path / "parts")


def test_what_does_not_fit_is_refused(out):
    def refused(match, env=None, **arguments):
        with pytest.raises(rher.InputError, match=match):
            trainer(env or Knob(), out, **arguments)
        assert not out.exists()

    refused(r"goals have \[4, 4\] numbers, expected 3 each for objects=1")
    refused(
        r"goals have \[4, 4\] numbers, expected 5 each for objects=1 and a tail of 2, or 2 where",
        tail=[*ANGLE, rher.Flag("lifted")],
    )
    nine = [rher.Quaternion("a", 1.0), rher.Quaternion("b", 1.0), rher.Flag("c")]
    refused("tail has 9 numbers, expected at most 8", tail=nine)
    refused("two parts called 'yaw', expected different names", tail=[*ANGLE, *ANGLE])
    refused("tail has 'yaw', expected rher.Number, rher.Angle", tail=["yaw"])
    refused("tolerance of yaw is -1", tail=[rher.Angle("yaw", -1.0)])
    refused("objects is 0 and tail is not empty", objects=0, tail=ANGLE)
    refused("positions is given, but goals have", tail=ANGLE, positions=[slice(3, 6)])
    free = Knob(places=False, quaternion=True)
    refused(r"goals have no positions, expected positions=", free, tail=ORIENTATION, positions=None)
    refused("positions has 0 slices, expected 1", free, tail=ORIENTATION, positions=[])
    refused("expected three numbers of the 8", free, tail=ORIENTATION, positions=[slice(3, 5)])

