"""What LeRobot has to know of a policy before it loads it."""

from dataclasses import dataclass

from lerobot.configs import FeatureType, PolicyFeature, PreTrainedConfig
from lerobot.utils.constants import ACTION, OBS_STR

__all__ = ["KEYS", "RherConfig"]

#: What an action follows from, by its name in a goal environment and by its name in LeRobot.
KEYS = {key: f"{OBS_STR}.{key}" for key in ("observation", "achieved_goal", "desired_goal")}


@PreTrainedConfig.register_subclass("rher")
@dataclass
class RherConfig(PreTrainedConfig):
    """A policy of rher; it acts on the CPU, and only rher trains it."""

    device: str | None = "cpu"

    def validate_features(self) -> None:
        """Checks that the parts of a goal environment's observation are there."""
        features = self.input_features or {}
        missing = [key for key in KEYS.values() if key not in features]
        if missing:
            raise ValueError(
                f"the features have no {', '.join(missing)}, expected those of a goal environment"
            )

    def get_optimizer_preset(self):
        """Refuses: LeRobot does not train it."""
        raise NotImplementedError("rher.train and rher.Trainer train these policies, not LeRobot")

    def get_scheduler_preset(self) -> None:
        """None: LeRobot does not train it."""

    @property
    def observation_delta_indices(self) -> None:
        """None: it acts by the present alone."""

    @property
    def action_delta_indices(self) -> None:
        """None: it answers one action at a time."""

    @property
    def reward_delta_indices(self) -> None:
        """None: it asks for no reward."""


def features_of(observation: int, goal: int, action: int) -> tuple[dict, dict]:
    """Input and output features of a policy with these widths."""
    kinds = {
        "observation": (FeatureType.STATE, observation),
        "achieved_goal": (FeatureType.ENV, goal),
        "desired_goal": (FeatureType.ENV, goal),
    }
    inputs = {KEYS[key]: PolicyFeature(kind, (width,)) for key, (kind, width) in kinds.items()}
    return inputs, {ACTION: PolicyFeature(FeatureType.ACTION, (action,))}
