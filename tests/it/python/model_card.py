"""Reads a model card with the package of the Hugging Face Hub, and prints its metadata as JSON."""

import json
import sys
from pathlib import Path

from huggingface_hub import ModelCard

card = ModelCard.load(Path(sys.argv[1]) / "README.md", ignore_metadata_errors=False)
data = card.data
assert data.model_name and "![" in card.text
results = [vars(result) for result in data.eval_results]
print(json.dumps({"library_name": data.library_name, "results": results}))
