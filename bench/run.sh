#!/usr/bin/env bash
# Measures the release build side by side with the peers, and how it scales; results go to build/bench/*.json, *.csv
# and *.svg.
# usage: bench/run.sh [--full] [NAME]... ; no name: all. --full: what measures scale (of_scale below) at the sizes that
# its targets are given for (up to 100 million points: docs/scaling.md).
# ORBWEAVE_DATA_DIR names the directory of real scans; without it only generated clouds are measured.
# ORBWEAVE_CLOUD_DIR may name one of ready clouds t<points>.ply.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

of_scans=(kernel right_surface same_bytes fill formats orientation raw_scans)
of_scale=(job threads chunks ranks simulate memory compression kills)
others=(scans_noise full_disk)

data=${ORBWEAVE_DATA_DIR:-../shared/data}
[ -d "$data/stanford" ] || echo "no real scans in $data (ORBWEAVE_DATA_DIR): generated clouds only"
full=()
if [ "${1:-}" = --full ]; then full=(--full); shift; fi
[ $# -gt 0 ] || set -- "${of_scans[@]}" "${of_scale[@]}" "${others[@]}"

is_of() { local name=$1 each; shift; for each in "$@"; do [ "$each" = "$name" ] && return 0; done; return 1; }

# Status 2 of ranks: there is no MPI here; 77 of full_disk: it may not mount.
measure() {
  local name=$1 check=() status=0
  [ "$name" = simulate ] && check=(--check)
  if is_of "$name" "${of_scans[@]}"; then "bench/$name.py" "$data" || status=$?
  elif is_of "$name" "${of_scale[@]}"; then "bench/$name.py" "${check[@]}" "${full[@]}" || status=$?
  elif is_of "$name" "${others[@]}"; then "bench/$name.py" || status=$?
  else
    echo "bench/run.sh: no benchmark \"$name\"; there are ${of_scans[*]} ${of_scale[*]} ${others[*]}" >&2
    exit 2
  fi
  [ "$name" = ranks ] && [ "$status" -eq 2 ] && status=0
  [ "$name" = full_disk ] && [ "$status" -eq 77 ] && status=0
  return "$status"
}

status=0
for name in "$@"; do
  printf '\n== %s\n' "$name"
  measure "$name" || status=1
done
exit "$status"
