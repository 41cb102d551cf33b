# Sourced by .ci/run and .ci/full: runs steps, keeps their logs, counts tests, prints a summary.
exec </dev/null
export CI=true NO_COLOR=1
logs=build/ci-logs
mkdir -p "$logs"
passed=0 failed=0 skipped=0
lines=()

# cpu_seconds FILE: what the commands before "times >FILE" took on all cores. On a shared machine a
# step's own cost is its CPU time, not its wall time.
cpu_seconds() { awk -F '[ms[:space:]]+' 'NR == 2 { printf "%d", ($1 + $3) * 60 + $2 + $4 }' "$1"; }

# step NAME COMMAND...: runs it, shows its output, counts its tests (one where it is no ctest run).
step() {
  local name=$1 log status=0 begin=$SECONDS counts tests_failed tests_run tests_skipped
  log=$logs/${name//[^a-z0-9]/-}.log
  shift
  printf '\n==> %s\n' "$name"
  times >"$logs/times-before"
  "$@" >"$log" 2>&1 || status=$?
  times >"$logs/times-after"
  counts=$(sed -nE 's/.*tests passed, ([0-9]+) tests? failed out of ([0-9]+).*/\1 \2/p' "$log" | tail -n 1)
  if [ "$status" -ne 0 ]; then tail -n 120 "$log"; else tail -n 25 "$log"; fi
  read -r tests_failed tests_run <<<"${counts:-0 1}"
  if [ "$status" -ne 0 ] && [ "$tests_failed" -eq 0 ]; then
    tests_failed=1
    [ -z "$counts" ] || tests_run=$((tests_run + 1))
  fi
  tests_skipped=$(grep -c '(Skipped)$' "$log")  # ctest counts them as passed
  skipped=$((skipped + tests_skipped))
  passed=$((passed + tests_run - tests_failed - tests_skipped)) failed=$((failed + tests_failed))
  lines+=("$(printf '%-46s %s in %d s, CPU %d s' "$name" "$([ $status -eq 0 ] && echo passed || echo FAILED)" \
    $((SECONDS - begin)) $(($(cpu_seconds "$logs/times-after") - $(cpu_seconds "$logs/times-before"))))")
}

# tested PRESET CTEST_OPTION...: builds everything in a preset and runs tests.
tested() {
  local preset=$1
  shift
  cached cmake --preset "$preset" >/dev/null &&
    cmake --build --preset "$preset" -j "$(nproc)" -- --quiet &&
    ctest --test-dir "build/$preset" --output-on-failure --no-tests=error -j "$(nproc)" "$@"
}

# thread_sanitizer WHAT: .ci/tsan; status 3 says that no mirror of Debian's sources is within reach.
thread_sanitizer() {
  local status=0
  .ci/tsan "$1" || status=$?
  [ "$status" -eq 3 ] || return "$status"
  echo "thread sanitizer: the sources of TBB cannot be fetched from here (Skipped)"
}

# cached COMMAND...: with ccache as the compiler's launcher where there is one.
cached() {
  if command -v ccache >/dev/null; then export CMAKE_CXX_COMPILER_LAUNCHER=ccache; fi
  "$@"
}

# summary: prints what was run; status 1 when anything failed.
summary() {
  printf '\nSummary (logs in %s)\n' "$logs"
  printf '  %s\n' "${lines[@]}"
  times >"$logs/times-after"
  printf '  total %d s, CPU %d s\n' "$SECONDS" "$(cpu_seconds "$logs/times-after")"
  [ "$skipped" -eq 0 ] || printf '%d skipped, by name above or in the logs\n' "$skipped"
  printf '%d passed, %d failed\n' "$passed" "$failed"
  [ "$failed" -eq 0 ]
}
