"""What is in a policy file: a network, and how its input is made of what is observed."""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rher import _rher
from rher.errors import FileError, PolicyError

__all__ = ["Layer", "PolicyFile", "read"]

#: Everything of an encoder that has a meaning here.
_ENCODER = {"frame", "observation", "slots", "turns", "fine_scale", "order"}


@dataclass(frozen=True)
class Layer:
    """A layer of the network; all but the last are rectified."""

    #: ``(inputs, outputs)``.
    weight: NDArray[np.float32]
    #: ``(outputs,)``.
    bias: NDArray[np.float32]
    #: Scale and shift of its layer normalization, ``(outputs,)`` each.
    norm: tuple[NDArray[np.float32], NDArray[np.float32]] | None


@dataclass(frozen=True)
class PolicyFile:
    """A policy, in plain numbers."""

    #: SHA-256 of the file.
    sha256: str
    #: The run that it is of.
    run: str | None
    #: Name of the environment.
    task: str
    #: Settings that the environment was made with.
    variant: str
    #: Number of objects.
    objects: int
    #: Number of sub-tasks, of which the last is the whole task.
    subtasks: int
    #: Length of an observation.
    observation: int
    #: Length of an action.
    action: int
    #: Where in an observation the three numbers of the gripper's position begin.
    gripper: int
    #: One for each object, for each number of an observation, and for each number of an action;
    #: empty where nobody knows.
    names: dict[str, list[str]]
    #: The rate, the frame and the units; empty where nobody knows.
    control: dict[str, Any]
    #: How the network's input is made, as ``rher_core::input`` writes it.
    encoder: dict[str, Any]
    #: The layers, first to last.
    layers: list[Layer]

    @property
    def inputs(self) -> dict[str, int]:
        """What an action follows from, and how many numbers each has."""
        goal = 3 * self.objects
        inputs = {"observation": self.observation, "achieved_goal": goal, "desired_goal": goal}
        if self.encoder.get("order"):
            inputs |= {"first_observation": self.observation, "first_achieved_goal": goal}
        return inputs

    @property
    def last(self) -> int:
        """The object that the last sub-task is about, counted from 0."""
        return (self.subtasks - 1) // 2

    @property
    def is_reach(self) -> bool:
        """Whether the last sub-task is to reach that object, and not to place it."""
        return self.subtasks % 2 == 1


def read(path: Path) -> PolicyFile:
    """Reads a policy file.

    :raise FileError: if it cannot be read.
    :raise PolicyError: if it is damaged or holds no policy, or one that only the package can act
        with.
    """
    # This checks everything that a damaged file can have wrong.
    _rher.Policy.load(path)
    try:
        file = path.read_bytes()
    except OSError as error:
        raise FileError(f"cannot read `{path}`: {error}") from error
    body = 8 + int.from_bytes(file[:8], "little")
    header: dict[str, Any] = json.loads(file[8:body])
    about: dict[str, Any] = json.loads(header.pop("__metadata__")["rher"])

    def tensor(name: str) -> NDArray[np.float32]:
        begin, end = header[name]["data_offsets"]
        numbers = np.frombuffer(file[body + begin : body + end], dtype="<f4")
        return numbers.astype(np.float32).reshape(header[name]["shape"])

    def layer(index: int) -> Layer:
        prefix = f"layers.{index}"
        norm = None
        if f"{prefix}.norm.scale" in header:
            norm = tensor(f"{prefix}.norm.scale"), tensor(f"{prefix}.norm.shift")
        return Layer(tensor(f"{prefix}.weight"), tensor(f"{prefix}.bias"), norm)

    if "tail" in about["encoder"]:
        raise PolicyError(
            f"the goals of `{path}` say more of objects than where they should be, which cannot be "
            "exported: expected a policy whose goals are positions"
        )
    unknown = sorted(set(about["encoder"]) - _ENCODER)
    if unknown:
        raise PolicyError(
            f"the network of `{path}` sees `{unknown[0]}`, which this version of the package cannot "
            "export: install the version that wrote the policy, or a newer one"
        )
    info, interface = about["about"], about.get("interface", {})
    names: dict[str, list[str]] = interface.get("names", {})
    variant: str = info.get("variant", "")
    return PolicyFile(
        sha256=hashlib.sha256(file).hexdigest(),
        run=about.get("run"),
        task=info["task"],
        variant=variant,
        objects=info["objects"],
        subtasks=info["subtasks"],
        observation=info["observation"],
        action=info["action"],
        gripper=_gripper(path, names.get("observation", []), variant),
        names=names,
        control=interface.get("control", {}),
        encoder=about["encoder"],
        layers=[layer(index) for index in range(len(about["shape"]["hidden"]) + 1)],
    )


def _gripper(path: Path, names: list[str], variant: str) -> int:
    """Where in an observation the gripper is: it has a name, or the policy remembers its place, as
    those of an environment of your own do.
    """
    position = [f"gripper.position.{axis}" for axis in "xyz"]
    for place in range(len(names) - 2):
        if names[place : place + 3] == position:
            return place
    try:
        settings = json.loads(variant)
    except json.JSONDecodeError:
        settings = None
    if isinstance(settings, dict) and isinstance(settings.get("gripper"), int):
        return int(settings["gripper"])
    raise PolicyError(
        f"`{path}` does not say where in an observation the gripper is, because an earlier version "
        "wrote it: train the policy with this version"
    )
