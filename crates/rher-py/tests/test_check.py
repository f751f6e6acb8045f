"""What is said of an environment before it is trained on, and of its symmetries."""

import gymnasium
import numpy as np
import pytest
import rher
from toy import STEPS, Carry, Flat


class Sound(Carry):
    """With the reward of Gymnasium-Robotics, and a hand that begins near the first object."""

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        if self.objects:
            self.things = np.clip(
                self.hand + self.np_random.uniform(-0.1, 0.1, (self.objects, 3)), 0, 1
            )
            self.things[:, 2] = 0
        self.goal = np.where(self.goal > 0.5, self.goal + 0.2, self.goal - 0.2) * [1, 1, 0]
        return self.seen(), {}

    def compute_reward(self, achieved, desired, info):
        apart = (achieved - desired).reshape(*np.shape(achieved)[:-1], -1, 3)
        within = np.linalg.norm(apart, axis=-1) <= self.distance_threshold
        return np.where(within.all(axis=-1), 0.0, -1.0)

    def step(self, action):
        seen, _, terminated, truncated, info = super().step(action)
        reward = self.compute_reward(seen["achieved_goal"], seen["desired_goal"], info)
        return seen, float(reward), terminated, truncated, info


def kinds(env, **arguments):
    problems = rher.check(env, **({"episode_steps": STEPS} | arguments))
    assert all(str(problem).startswith(problem.kind) for problem in problems)
    return {problem.kind: problem.message for problem in problems}


@pytest.mark.parametrize("objects", [0, 1])
def test_nothing_is_found_in_a_sound_environment(objects):
    assert kinds(Sound(objects), objects=objects) == {}
    assert kinds(Flat(Carry(0)), objects=0) == {}


def changed(method, objects=1):
    """An environment in which one method is another one."""
    name = method.__name__
    return type("Changed", (Sound,), {name: method})(objects)


def test_rewards_that_are_not_those_that_are_learned_from_are_named():
    def step(self, action):
        seen, _, *rest = Sound.step(self, action)
        return seen, 0.5, *rest

    assert "differ from compute_reward" in kinds(changed(step))["reward"]

    def compute_reward(self, achieved, desired, info):
        return -np.linalg.norm(achieved - desired, axis=-1)

    assert "more than two values" in kinds(changed(compute_reward))["reward"]

    def compute_reward(self, achieved, desired, info):
        return np.where(np.linalg.norm(achieved - desired, axis=-1) <= 0.08, 0.0, -1.0)

    # The distance of both goals together is less than the larger of the two times the root of two.
    said = kinds(changed(compute_reward, 2), objects=2)["tolerance"]
    assert "as the distance of all goals together" in said
    tolerance = float(said.split("pass tolerance=")[1])
    assert 0.05 < tolerance < 0.08 / 2**0.5
    said = kinds(changed(compute_reward, 1))["tolerance"]
    assert "as the tolerance of every object: pass tolerance=0.07" in said
    assert "tolerance" not in kinds(changed(compute_reward, 1), tolerance=0.08)

    def compute_reward(self, achieved, desired, info):
        return np.where(achieved[..., 0] > desired[..., 0], 0.0, -1.0) * np.any(achieved != desired)

    assert "cannot be learned" in kinds(changed(compute_reward))["tolerance"]


def test_goals_that_teach_nothing_are_named():
    assert "20 of 20 goals were reached" in kinds(Sound(1), tolerance=9.0)["solved"]

    def seen(self):
        self.goal = self.goal + 0.01
        return Sound.seen(self)

    assert "changed during" in kinds(changed(seen))["goal"]


def test_objects_that_stay_where_they_are_are_named():
    def reset(self, *, seed=None, options=None):
        Sound.reset(self, seed=seed)
        self.things = self.things * 0 + [9.0, 9.0, 0.0]
        return self.seen(), {}

    assert "object 1 moved in none of 20 episodes" in kinds(changed(reset))["still"]
    assert kinds(changed(reset, 0), objects=0) == {}


def test_a_gripper_that_is_none_is_named():
    assert "it is that object" in kinds(Sound(1), gripper=slice(3, 6))["gripper"]

    def seen(self):
        numbers = Sound.seen(self)
        return numbers | {"observation": np.append(numbers["observation"], [0, 0, 1])}

    env = changed(seen)
    env.observation_space.spaces["observation"] = gymnasium.spaces.Box(-2.0, 2.0, (9,), np.float64)
    assert "did not change with random actions" in kinds(env, gripper=slice(6, 9))["gripper"]

    def seen(self):
        numbers = Sound.seen(self)
        return numbers | {"observation": numbers["observation"] * np.repeat([1000, 1], 3) + 5000}

    assert "in one frame and in the same unit" in kinds(changed(seen))["gripper"]

    def seen(self):
        return Sound.seen(self) | {"achieved_goal": self.hand + 1}

    assert "away from achieved_goal" in kinds(changed(seen, 0), objects=0)["gripper"]


def test_what_would_be_refused_or_cannot_be_played_is_an_error():
    with pytest.raises(rher.InputError, match="goals have"):
        rher.check(Sound(1), objects=2, episode_steps=STEPS)

    def step(self, action):
        raise ValueError("the robot fell over")

    with pytest.raises(rher.EnvError, match="the robot fell over"):
        kinds(changed(step))

    def step(self, action):
        seen, *rest = Sound.step(self, action)
        return seen | {"achieved_goal": np.full(3, np.nan)}, *rest

    with pytest.raises(rher.EnvError, match="achieved_goal is .*nan"):
        kinds(changed(step))
    with pytest.raises(rher.InputError, match="steps is 0"):
        rher.check(Sound(1), steps=0)


class Open(Sound):
    """Without walls, so that its mirrors hold everywhere, and with a speed in its observations."""

    wind = 0.0

    def __init__(self, objects=1):
        super().__init__(objects)
        box = gymnasium.spaces.Box(-9.0, 9.0, (5 + 3 * objects,), np.float64)
        self.observation_space.spaces["observation"] = box
        self.spec = gymnasium.envs.registration.EnvSpec("Open-v0", max_episode_steps=STEPS)

    def reset(self, *, seed=None, options=None):
        self.speed = np.zeros(2)
        super().reset(seed=seed)
        return self.seen(), {}

    def step(self, action):
        held = np.linalg.norm(self.things - self.hand, axis=1) < 0.12
        self.speed = 0.5 * self.speed + 0.05 * action + [self.wind, 0]
        self.hand[:2] += self.speed
        self.things[held] = self.hand
        self.steps += 1
        return self.seen(), 0.0, False, self.steps == STEPS, {}

    def seen(self):
        numbers = super().seen()
        seen = np.concatenate([numbers["observation"], self.speed])
        return numbers | {"observation": seen}


def test_mirrors_are_proposed_and_tested():
    x, y, z = rher.symmetries(Open(1))
    assert [one.symmetry.axis for one in (x, y, z)] == [0, 1, 2]
    for one, number in ((x, 0), (y, 1)):
        assert not one.is_refuted and number in one.explained, one
        mirror = one.symmetry
        flipped = [index for index, image in enumerate(mirror.observation) if image.sign == -1]
        # The hand, the block and the speed.
        assert flipped == [number, 3 + number, 6 + number]
        assert [image.sign for image in mirror.action] == [
            1 - 2 * (number == 0),
            1 - 2 * (number == 1),
        ]
        assert mirror.observation[number].offset == 2 * mirror.center
        assert mirror.observation[6 + number].offset == 0

    class Windy(Open):
        wind = 0.05

    x, y, _ = rher.symmetries(Windy(1))
    assert x.is_refuted and x.worst in (0, 3, 6) and not y.is_refuted


def test_a_symmetry_with_a_wrong_sign_is_refuted():
    good = {
        "axis": 1,
        "center": 0.5,
        "observation": 8,
        "action": 2,
        "places": [1, 4],
        "actions": [1],
    }
    wrong = [
        rher.Mirror.flipping(**good),
        rher.Mirror.flipping(**good | {"others": [7], "actions": []}),
    ]
    right = rher.Mirror.flipping(**good, others=[7])
    missing, unmoved, whole = rher.symmetries(Open(1), mirrors=[*wrong, right])
    assert missing.is_refuted and unmoved.is_refuted and not whole.is_refuted
    with pytest.raises(rher.InputError, match="a symmetry has 7 numbers, expected 8"):
        rher.symmetries(Open(1), mirrors=[rher.Mirror.flipping(**good | {"observation": 7})])


def test_objects_that_trade_names_are_tested():
    keep = [rher.Image(index) for index in range(11)]
    trade = [*keep[:3], *keep[6:9], *keep[3:6], *keep[9:]]
    forgotten = [*trade[:5], keep[5], *trade[6:]]
    speed = [*trade[:9], keep[0], keep[10]]
    tested = rher.symmetries(
        Open(2),
        objects=2,
        mirrors=[],
        permutations=[rher.Permutation([1, 0], images) for images in (trade, forgotten, speed)],
    )
    assert [one.is_refuted for one in tested] == [False, True, True]
    assert [one.worst for one in tested[1:]] == [5, 9]


SYMMETRIC = {
    "mirrors": [
        rher.Mirror.flipping(
            axis=0, center=0.5, observation=9, action=2, places=[0, 3, 6], actions=[0]
        )
    ],
    "permutations": [
        rher.Permutation([1, 0], [rher.Image(index) for index in (0, 1, 2, 6, 7, 8, 3, 4, 5)])
    ],
}


def test_a_run_learns_from_images(tiny, tmp_path):
    def run(name, **arguments):
        settings = tiny | {"relay.mirror": 0.5, "relay.exchange": 0.5}
        out = tmp_path / name
        with rher.Trainer(
            Carry(2), objects=2, episode_steps=STEPS, set=settings, out=out, **arguments
        ) as one:
            return one.learn(env_steps=10 * STEPS)

    runs = {name: run(name, **{name: given}) for name, given in SYMMETRIC.items()}
    runs["plain"] = run("plain")
    losses = {float(one.metrics["critic_loss"][-1]) for one in runs.values()}
    assert len(losses) == 3
    # A symmetry is a part of what a run is.
    with pytest.raises(rher.InputError, match="the run was made in"):
        rher.Trainer(Carry(2), objects=2, episode_steps=STEPS, resume=tmp_path / "mirrors")
    rher.Trainer(
        Carry(2),
        objects=2,
        episode_steps=STEPS,
        resume=tmp_path / "mirrors",
        mirrors=SYMMETRIC["mirrors"],
    ).close()
    assert runs["mirrors"].policy(Carry(2).reset(seed=0)[0]).shape == (2,)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"mirrors": [3]}, "expected rher.Mirrors"),
        ({"mirrors": SYMMETRIC["permutations"]}, "expected rher.Mirrors"),
        ({"mirrors": [rher.Mirror(3, 0.0, [], [])]}, "axis is 3"),
        (
            {"mirrors": [rher.Mirror(0, 0.0, [rher.Image(0)] * 9, [rher.Image(0)] * 2)]},
            r"mirrors\[0\]",
        ),
        ({"mirrors": [rher.Mirror(0, 0.0, [rher.Image(0)], [])]}, r"mirrors\[0\]"),
        ({"permutations": [rher.Permutation([0, 1, 2], [])]}, "expected 2 objects"),
        ({"permutations": [rher.Permutation([0, 0], [rher.Image(0)] * 9)]}, r"permutations\[0\]"),
        ({"permutations": [rher.Permutation([1, 0], [rher.Image(0)] * 9)]}, r"permutations\[0\]"),
    ],
)
def test_what_is_no_symmetry_is_refused(arguments, message, tiny, out):
    with pytest.raises((rher.InputError, rher.SettingsError), match=message):
        rher.Trainer(Carry(2), objects=2, episode_steps=STEPS, set=tiny, out=out, **arguments)
    with pytest.raises(rher.InputError, match="a number of places is 9"):
        rher.Mirror.flipping(axis=0, center=0, observation=9, action=2, places=[9], actions=[])
