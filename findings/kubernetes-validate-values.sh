#!/usr/bin/env bash
# kubernetes-validate 1.37.0: `--strict` lets misspelled values, negative counts, keys that are there
# twice and an empty file pass. Kubernetes accepts none of these manifests; it looks for unknown and
# for duplicate fields where it validates strictly.
#
# A good guess: what has a fixed list of values in the API reference, such as `completionMode`, is compared
# with it, and strict validation is what Kubernetes means by it.
#
# Seen:
#   valid: INFO job.yaml passed for resource job/job against version 1.37 (0)
#   values: INFO job.yaml passed for resource job/job against version 1.37 (0)
#   negative: INFO job.yaml passed for resource job/job against version 1.37 (0)
#   twice: INFO job.yaml passed for resource job/job against version 1.37 (0)
#   empty:  (0)
#   unknown: ERROR job.yaml did not validate for resource job/job against version 1.37: spec: Additional properties are not allowed ('completion' was unexpected) (1)
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check kubernetes-validate==1.37.0
cd "$folder"

# A valid Job, changed by a command of sed.
validate() {
  sed "$2" > job.yaml <<'YAML'
apiVersion: batch/v1
kind: Job
metadata:
  name: job
spec:
  completionMode: Indexed
  completions: 2
  template:
    spec:
      restartPolicy: Never
      containers:
        - name: main
          image: example
YAML
  status=0
  said=$(venv/bin/kubernetes-validate -k 1.37 --strict job.yaml 2>&1) || status=$?
  echo "$1: $said ($status)"
}

validate valid ''
for change in 'values s/Indexed/Indexd/;s/Never/Newer/' 'negative s/completions: 2/completions: -2/' \
  'twice s/completions: 2/&\n  completions: 3/' 'empty d'; do
  validate "${change%% *}" "${change#* }"
  if [ "$status" != 0 ]; then
    echo "kubernetes-validate behaves differently now"
    exit 1
  fi
done
validate unknown 's/completions/completion/'
[ "$status" = 1 ]
