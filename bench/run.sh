#!/usr/bin/env bash
# Measures the release build side by side with the peers; results go to build/bench/*.json and *.csv.
# usage: bench/run.sh [kernel|right_surface|same_bytes|job|fill|formats|orientation|raw_scans|scans_noise]... ; none: all
# ORBWEAVE_DATA_DIR names the directory of real scans; without it only generated clouds are measured.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
data=${ORBWEAVE_DATA_DIR:-../shared/data}
[ -d "$data/stanford" ] || echo "no real scans in $data (ORBWEAVE_DATA_DIR): generated clouds only"
[ $# -gt 0 ] || set -- kernel right_surface same_bytes job fill formats orientation raw_scans scans_noise
status=0
for name in "$@"; do
  printf '\n== %s\n' "$name"
  case "$name" in
    kernel | right_surface | same_bytes | fill | formats | orientation | raw_scans) "bench/$name.py" "$data" || status=1 ;;
    job | scans_noise) "bench/$name.py" || status=1 ;;
    *) echo "bench/run.sh: no benchmark \"$name\"; there are kernel, right_surface, same_bytes, job, fill, formats, orientation, raw_scans, scans_noise" >&2; exit 2 ;;
  esac
done
exit "$status"
