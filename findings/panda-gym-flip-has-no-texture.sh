#!/usr/bin/env bash
# panda-gym 3.0.7: `gymnasium.make("PandaFlip-v3")` fails, since the picture of its cube is in no
# package; and the goal of an episode does not follow its seed.
#
# A good guess: an environment that is registered can be made, and `reset(seed=0)` always asks for the
# same goal. Neither the wheel nor the source package has `colored_cube.png`, and the goal comes from
# the generator of the whole process.
#
# Seen:
#   as installed: Error loading texture
#   with a picture: two resets with seed 0 ask for the same goal: False
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# Its simulator has wheels up to Python 3.11.
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary pybullet \
  panda-gym==3.0.7 pybullet==3.2.7 gymnasium==1.4.0 numpy==2.4.6 scipy==1.17.1
"$folder/venv/bin/python" -W ignore - <<'EOF' | grep -v -e '^argv' -e '^pybullet'
import struct
import zlib

import gymnasium
import numpy as np
import panda_gym
import panda_gym.assets

try:
    gymnasium.make("PandaFlip-v3")
    error = None
except Exception as raised:
    error = str(raised)
print(f"as installed: {error}")
assert error == "Error loading texture", "panda-gym behaves differently now"


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


header = struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)
picture = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header)
picture += chunk(b"IDAT", zlib.compress(bytes(4))) + chunk(b"IEND", b"")
with open(f"{panda_gym.assets.get_data_path()}/colored_cube.png", "wb") as file:
    file.write(picture)
env = gymnasium.make("PandaFlip-v3", disable_env_checker=True)
goals = [env.reset(seed=0)[0]["desired_goal"] for _ in range(2)]
same = bool(np.array_equal(*goals))
print(f"with a picture: two resets with seed 0 ask for the same goal: {same}")
assert not same, "panda-gym behaves differently now"
EOF
