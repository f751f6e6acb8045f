#!/usr/bin/env bash
# MLflow 3.17.2: `mlflow-skinny` keeps runs by default in a database, `sqlite:///mlflow.db`, which it
# cannot open, because what it needs for that is in the package `mlflow` only. Nothing can be logged
# before MLFLOW_TRACKING_URI says another place; a folder needs MLFLOW_ALLOW_FILE_STORE=true, too.
#
# A good guess: the default of a package works in it.
#
# Seen:
#   by default: …UnsupportedModelRegistryStoreURIException: … got unsupported URI 'sqlite:…/mlflow.db'
#   a folder: …MlflowException: The filesystem tracking backend … is in maintenance mode
#   a folder, allowed: 1 run
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check mlflow-skinny==3.17.2
cd "$folder"
log() {
  env -u MLFLOW_TRACKING_URI -u MLFLOW_ALLOW_FILE_STORE "$@" "$folder/venv/bin/python" - 2>&1 <<'PYTHON' | tail -n 1
from mlflow import MlflowClient

client = MlflowClient()
client.create_run(client.create_experiment("one"))
print(f"{len(client.search_runs([client.get_experiment_by_name('one').experiment_id]))} run")
PYTHON
}
by_default=$(log || true)
in_folder=$(log MLFLOW_TRACKING_URI="file://$folder/runs" || true)
allowed=$(log MLFLOW_TRACKING_URI="file://$folder/runs" MLFLOW_ALLOW_FILE_STORE=true)
echo "by default: $by_default"
echo "a folder: $in_folder"
echo "a folder, allowed: $allowed"
[[ $by_default == *"unsupported URI 'sqlite:"* ]]
[[ $in_folder == *"is in maintenance mode"* ]]
[[ $allowed == "1 run" ]]
