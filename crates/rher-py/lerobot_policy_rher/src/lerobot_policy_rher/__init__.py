"""Policies of rher, and its environments, in LeRobot: type ``rher`` of both.

LeRobot imports this package by itself, because its name begins with ``lerobot_policy_``.
"""

from lerobot_policy_rher.configuration_rher import RherConfig
from lerobot_policy_rher.environment_rher import RherEnvConfig

__all__ = ["RherConfig", "RherEnvConfig"]
