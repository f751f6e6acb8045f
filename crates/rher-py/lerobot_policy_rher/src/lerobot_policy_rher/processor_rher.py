"""What LeRobot does before and after a policy: nothing but moving numbers between devices."""

from typing import Any

from lerobot.processor import (
    DeviceProcessorStep,
    PolicyAction,
    PolicyProcessorPipeline,
    RenameObservationsProcessorStep,
    make_policy_processor_pipelines,
)
from lerobot_policy_rher.configuration_rher import RherConfig

__all__ = ["make_rher_pre_post_processors"]


def make_rher_pre_post_processors(
    config: RherConfig, dataset_stats: dict[str, Any] | None = None
) -> tuple[
    PolicyProcessorPipeline[dict[str, Any], dict[str, Any]],
    PolicyProcessorPipeline[PolicyAction, PolicyAction],
]:
    """Both pipelines; the policy normalizes by itself, so statistics change nothing."""
    return make_policy_processor_pipelines(
        [RenameObservationsProcessorStep(rename_map={}), DeviceProcessorStep(device=config.device)],
        [DeviceProcessorStep(device="cpu")],
    )
