"""Our tasks with several blocks in MuJoCo: the Fetch robot of Gymnasium-Robotics and more blocks.

The robot, its control, its rate and the blocks are that package's. How an episode begins, what an
observation consists of and what counts as success is asked of our tasks.
"""

import tempfile
from collections.abc import Iterator, Mapping
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np
from gymnasium_robotics.envs.fetch.fetch_env import MujocoFetchEnv
from gymnasium_robotics.envs.fetch.pick_and_place import MujocoFetchPickAndPlaceEnv
from gymnasium_robotics.envs.fetch.push import MujocoFetchPushEnv
from gymnasium_robotics.utils import mujoco_utils, rotations
from numpy.typing import ArrayLike, NDArray

import rher
from rher.compare import block_model

__all__ = ["TASKS", "Blocks", "make", "names"]

Vector = NDArray[np.float64]


def make(task: str, **arguments: Any) -> gymnasium.Env[Any, Any]:
    """One of :data:`TASKS` in MuJoCo; its episodes have as many steps as ours.

    Observations and goals are those of ``rher.TaskEnv(task)``, number by number, and the same seed
    puts blocks and goals at the same places.

    :param arguments: those of Gymnasium-Robotics: ``render_mode``, ``width``, ``height``.
    """
    ours = rher.TaskEnv(task)
    return gymnasium.wrappers.TimeLimit(TASKS[task](ours, **arguments), ours.episode_steps)


@cache
def names(task: str) -> list[str]:
    """What the numbers of an observation of a task are called, in their order."""
    return rher.Policy.pretrained(task).names["observation"]


class Blocks(MujocoFetchEnv):
    """An environment of Gymnasium-Robotics with as many blocks as a task of ours has."""

    def __init__(self, ours: rher.TaskEnv, **arguments: Any) -> None:
        self._ours = ours
        self._begun, _ = ours.reset(seed=0)
        # A number that is there several times has a name that ends in `#2` from the second on.
        self._names = [name.partition("#")[0] for name in names(ours.task)]
        super().__init__(**arguments)

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[dict[str, Vector], dict[str, Any]]:
        """Starts the episode that our task starts with this seed and these options."""
        self._begun, _ = self._ours.reset(seed=seed, options=options)
        return super().reset(seed=seed)

    def compute_reward(self, achieved_goal: ArrayLike, desired_goal: ArrayLike, info: Any) -> Any:
        """The rewards of our task."""
        return self._ours.compute_reward(achieved_goal, desired_goal, info)

    def _is_success(self, achieved_goal: ArrayLike, desired_goal: ArrayLike) -> bool:
        return bool(self.compute_reward(achieved_goal, desired_goal, {}) == 0)

    def _initialize_simulation(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            model, blocks = Path(self.fullpath), self._ours.objects
            self.fullpath = str(block_model.copied(model, blocks, Path(folder)))
            super()._initialize_simulation()

    def _reset_sim(self) -> bool:
        super()._reset_sim()
        begun = dict(zip(self._names, self._begun["observation"], strict=True))
        for block, place in enumerate(_by_three(self._begun["achieved_goal"])):
            half = begun[f"block{block + 1}.rotation.z"] / 2
            pose = [*place, np.cos(half), 0.0, 0.0, np.sin(half)]
            joint = f"object{block}:joint"
            mujoco_utils.set_joint_qpos(self.model, self.data, joint, pose)
            mujoco_utils.set_joint_qvel(self.model, self.data, joint, np.zeros(6))
        mujoco.mj_forward(self.model, self.data)
        return True

    def _sample_goal(self) -> Vector:
        return self._begun["desired_goal"]

    def _get_obs(self) -> dict[str, Vector]:
        seen = dict(self._seen())
        return {
            "observation": np.array([seen[name] for name in self._names]),
            "achieved_goal": np.concatenate(self._places()),
            "desired_goal": self.goal.copy(),
        }

    def _places(self) -> list[Vector]:
        """Where the blocks are, in meters."""
        return [self.data.site(f"object{block}").xpos.copy() for block in range(self._ours.objects)]

    def _seen(self) -> Iterator[tuple[str, float]]:
        """Every number that an observation can have: meters, radians, and either per step."""
        model, data = self.model, self.data
        hand = mujoco_utils.get_site_xpos(model, data, "robot0:grip")
        hand_velocity = mujoco_utils.get_site_xvelp(model, data, "robot0:grip") * self.dt
        vectors = {"gripper.position": hand, "gripper.velocity": hand_velocity}
        places = self._places()
        for block, place in enumerate(places):
            name, site = f"block{block + 1}", f"object{block}"
            rotation = mujoco_utils.get_site_xmat(model, data, site)
            velocity = mujoco_utils.get_site_xvelp(model, data, site) * self.dt
            spin = mujoco_utils.get_site_xvelr(model, data, site) * self.dt
            vectors |= {
                f"{name}.position": place,
                f"{name}.from_gripper": place - hand,
                f"{name}.rotation": rotations.mat2euler(rotation),
                f"{name}.velocity": velocity - hand_velocity,
                f"{name}.spin": spin,
            }
        for (one, place), (other, there) in combinations(enumerate(places, 1), 2):
            vectors[f"block{one}.from_block{other}"] = place - there
        for what, vector in vectors.items():
            yield from ((f"{what}.{axis}", number) for axis, number in zip("xyz", vector))
        # Ours are, too, in the order from +y to -y.
        for finger, side in enumerate("rl", 1):
            joint = data.joint(f"robot0:{side}_gripper_finger_joint")
            yield f"finger{finger}.opening", joint.qpos[0]
            yield f"finger{finger}.velocity", joint.qvel[0] * self.dt

    def _render_callback(self) -> None:
        # Not by `mj_forward`, as in the environments with one block: it changes what comes next.
        for block, goal in enumerate(_by_three(self.goal)):
            self.data.site(f"target{block}").xpos = goal


class _Pushed(Blocks, MujocoFetchPushEnv):
    """Closed fingers that begin on the table."""


class _Grasped(Blocks, MujocoFetchPickAndPlaceEnv):
    """Fingers that open, and begin in the air."""


#: The tasks that there are.
TASKS: dict[str, type[Blocks]] = {
    "dpush": _Pushed,
    "stack": _Grasped,
    "tpush": _Pushed,
    "tstack": _Grasped,
}


def _by_three(goal: Vector) -> Vector:
    """The objects of a goal, a row for each."""
    return goal.reshape(-1, 3)
