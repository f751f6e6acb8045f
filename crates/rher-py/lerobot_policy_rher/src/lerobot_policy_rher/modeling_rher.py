"""A policy of rher as LeRobot calls it."""

from pathlib import Path
from typing import Any

import rher
import torch
from huggingface_hub.constants import SAFETENSORS_SINGLE_FILE
from lerobot.policies import PreTrainedPolicy
from lerobot_policy_rher.configuration_rher import KEYS, RherConfig
from torch import Tensor

__all__ = ["RherPolicy"]


class RherPolicy(PreTrainedPolicy):
    """A trained policy; ``model.safetensors`` beside its configuration is rher's own policy file."""

    config_class = RherConfig
    name = "rher"

    def __init__(self, config: RherConfig, *, policy: rher.Policy | None = None, **_: Any) -> None:
        super().__init__(config)
        self.policy = policy
        self._begun: rher.Policy | None = None

    @classmethod
    def _load_as_safetensor(
        cls, model: "RherPolicy", model_file: str, map_location: str, strict: bool
    ) -> "RherPolicy":
        model.policy = rher.Policy.load(model_file)
        return model

    def _save_pretrained(
        self, save_directory: Path, state_dict: dict[str, Tensor] | None = None
    ) -> None:
        self.config._save_pretrained(save_directory)
        self._loaded().save(save_directory / SAFETENSORS_SINGLE_FILE)

    def _loaded(self) -> rher.Policy:
        if self.policy is None:
            raise ValueError(
                "the policy has no network: expected --policy.path with a folder that "
                "`python -m lerobot_policy_rher` wrote"
            )
        return self.policy

    def reset(self) -> None:
        """The next observations are the first of their episodes."""
        self._begun = None

    def select_action(self, batch: dict[str, Tensor], **_: Any) -> Tensor:
        """The actions for a batch of observations and goals, ``(batch, action)``, within -1 and 1.

        With the first batch after :meth:`reset`, the policy chooses the order of the objects in each
        environment, where it has learned to.

        :raise rher.InputError: if a number is not finite, or a width is not the policy's.
        """
        missing = [key for key in KEYS.values() if key not in batch]
        if missing:
            raise ValueError(
                f"the batch has no {', '.join(missing)}, expected what a goal environment returns"
            )
        rows = {name: batch[key].detach().cpu().numpy() for name, key in KEYS.items()}
        if self._begun is None:
            self._begun = self._loaded().begin(rows)
        return torch.from_numpy(self._begun(rows))

    def predict_action_chunk(self, batch: dict[str, Tensor], **_: Any) -> Tensor:
        """The same as a chunk of one action, ``(batch, 1, action)``."""
        return self.select_action(batch)[:, None]

    def forward(self, batch: dict[str, Tensor]) -> tuple[Tensor, dict | None]:
        """Refuses: LeRobot does not train it."""
        raise NotImplementedError("rher.train and rher.Trainer train these policies, not LeRobot")

    def get_optim_params(self) -> dict:
        """Nothing: LeRobot does not train it."""
        return {}
