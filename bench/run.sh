#!/usr/bin/env bash
# Measures the release build side by side with the peers, and how it scales; results go to build/bench/*.json, *.csv
# and *.svg.
# workloads/ measures seconds and memory, quality/ how good the surface is, models/ predicts clusters, peers/ holds what
# runs other programs, study/ repeats the base paper's comparison (docs/study.md).
# usage: bench/run.sh [--full] [NAME]... ; no name: all. --full: what measures scale (of_scale below) at the sizes that
# its targets are given for (up to 100 million points: docs/scaling.md).
# ORBWEAVE_DATA_DIR names the directory of real scans; without it only generated clouds are measured.
# ORBWEAVE_CLOUD_DIR may name one of ready clouds t<points>.ply.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

of_scans=(workloads/kernel workloads/scan_speed workloads/mosaics quality/right_surface same_bytes quality/fill workloads/formats quality/orientation
  quality/raw_scans peers/raw_peers study/study)
of_scale=(workloads/job workloads/threads workloads/chunks workloads/ranks models/simulate workloads/memory
  workloads/compression)
others=(workloads/hostile workloads/large_holes quality/scans_noise quality/noise_growth quality/orientation_cases quality/round_trip
  workloads/python_module)

data=${ORBWEAVE_DATA_DIR:-../shared/data}
[ -d "$data/stanford" ] || echo "no real scans in $data (ORBWEAVE_DATA_DIR): generated clouds only"
full=()
if [ "${1:-}" = --full ]; then full=(--full); shift; fi
[ $# -gt 0 ] || set -- "${of_scans[@]}" "${of_scale[@]}" "${others[@]}"

# script_of NAME LIST...: the script of that name in a list; status 1 where it is not in the list.
script_of() {
  local name=$1 each
  shift
  for each in "$@"; do
    [ "${each##*/}" = "${name##*/}" ] || continue
    if [ "$each" = same_bytes ]; then echo tests/soak/scans_same_bytes.py; else echo "bench/$each.py"; fi
    return
  done
  return 1
}

# Status 2 of ranks: there is no MPI here.
measure() {
  local name=${1##*/} script check=() status=0
  [ "$name" = simulate ] && check=(--check)
  if script=$(script_of "$name" "${of_scans[@]}"); then "$script" "$data" || status=$?
  elif script=$(script_of "$name" "${of_scale[@]}"); then "$script" "${check[@]}" "${full[@]}" || status=$?
  elif script=$(script_of "$name" "${others[@]}"); then "$script" || status=$?
  else
    echo "bench/run.sh: no benchmark \"$name\"; there are ${of_scans[*]} ${of_scale[*]} ${others[*]}" >&2
    exit 2
  fi
  [ "$name" = ranks ] && [ "$status" -eq 2 ] && status=0
  return "$status"
}

status=0
for name in "$@"; do
  printf '\n== %s\n' "$name"
  measure "$name" || status=1
done
exit "$status"
