"""Opens a dataset with LeRobot, and prints what is in it as JSON."""

import json
import sys

import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset

root = sys.argv[1]
dataset = LeRobotDataset("rher/test", root=root)
item = dataset[0]
second = LeRobotDataset("rher/test", root=root, episodes=[1])
window = LeRobotDataset("rher/test", root=root, delta_timestamps={"action": [0.0, 0.04, 0.08]})
batch = next(iter(torch.utils.data.DataLoader(dataset, batch_size=8, shuffle=True)))
print(
    json.dumps(
        {
            "episodes": dataset.num_episodes,
            "frames": dataset.num_frames,
            "fps": dataset.fps,
            "task": item["task"],
            "shapes": {name: list(value.shape) for name, value in item.items() if name != "task"},
            "batch": {
                name: list(batch[name].shape) for name in ["observation.state", "next.reward"]
            },
            "second": [second.num_episodes, second.num_frames, int(second[0]["episode_index"])],
            "window": list(window[0]["action"].shape),
            "stats": sorted(dataset.meta.stats["action"]),
            "done": [bool(dataset[index]["next.done"]) for index in (0, 48, 49)],
            "first_action": item["action"].tolist(),
            "time": float(dataset[49]["timestamp"]),
        }
    )
)
