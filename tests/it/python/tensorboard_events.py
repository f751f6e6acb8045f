"""Prints what TensorBoard reads in a folder, as JSON: the points of every tag."""

import json
import sys

from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

events = EventAccumulator(sys.argv[1], size_guidance={"scalars": 0, "tensors": 0}).Reload()
tags = events.Tags()
print(json.dumps({tag: [[e.step, e.value] for e in events.Scalars(tag)] for tag in tags["scalars"]}))
