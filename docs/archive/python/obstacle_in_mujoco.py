"""How far a hand that presses on an obstacle moves along it in MuJoCo, in millimetres per step.

A box of the size of obstacle-push stands in FetchPush-v4, in front of the hand.
Needs gymnasium-robotics and mujoco.
"""

import shutil
import tempfile
from pathlib import Path

import gymnasium_robotics
import mujoco
import numpy as np
from gymnasium_robotics.envs.fetch import push

AWAY, THERE = [1.4317, 3.0, 0.425], [1.4317, 0.7663, 0.425]
BOX = '<body name="obstacle" pos="1.4317 3 0.425"><geom type="box" size="0.01 0.04 0.025"/></body>'

with tempfile.TemporaryDirectory() as folder:
    assets = Path(folder) / "assets"
    shutil.copytree(Path(gymnasium_robotics.__file__).parent / "envs/assets", assets)
    scene = assets / "fetch/push.xml"
    scene.write_text(scene.read_text().replace("</worldbody>", BOX + "</worldbody>"))
    push.MODEL_XML_PATH = str(scene)
    env = push.MujocoFetchPushEnv()

obstacle = mujoco.mj_name2id(env.model, mujoco.mjtObj.mjOBJ_BODY, "obstacle")
for action in ([1, 0.2, 0, 0], [1, 0.5, 0, 0], [1, 0, 1, 0], [1, 0, 0.5, 0]):
    env.model.body_pos[obstacle] = AWAY
    env.reset(seed=1)
    block = env._utils.get_joint_qpos(env.model, env.data, "object0:joint")
    block[:2] = [1.2, 0.9]
    env._utils.set_joint_qpos(env.model, env.data, "object0:joint", block)
    env.model.body_pos[obstacle] = THERE
    mujoco.mj_forward(env.model, env.data)
    hands = [env.step(np.array(action, np.float32))[0]["observation"][:3] for _ in range(5)]
    moved = np.linalg.norm((hands[4] - hands[2])[1:]) / 2
    print(action, round(1000 * float(moved), 1))
