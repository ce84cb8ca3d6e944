#!/bin/bash
# All benchmarks, one table: bash tests/bench/run.sh [--quick]
#
#   --quick  one short run, to check that it works; its figures are not valid
#
# Installs what it needs (Debian), builds, measures for about five minutes and prints Markdown.
# Needs a quiet machine, and root or limits that permit SCHED_FIFO. The comments at the top of
# beat.py and of each bench_*.cpp describe the measurements; docs/dev/results.md has results.
set -euo pipefail
cd "$(dirname "$0")/../.."

usage() {
  sed -n '2,4s/^# \{0,1\}//p' "$0" >&2
  exit 2
}
runs=5 repetitions=9 seconds=15 min_time=0.1
case $* in
  '') ;;
  --quick) runs=1 repetitions=3 seconds=2 min_time=0.02 ;;
  *) usage ;;
esac
drive_seconds=400

work=$(mktemp -d --tmpdir=/dev/shm odomd-bench-XXXXXX)
broker=
clean_up() {
  [ -z "$broker" ] || { kill "$broker" && wait "$broker"; } 2>/dev/null || true
  rm -rf "$work"
}
trap clean_up EXIT
trap 'exit 130' INT TERM

# step COMMAND...: its output goes to a log; on failure, the log's end goes to standard error.
step() { "$@" >>"$work/log" 2>&1 || { tail -n 20 "$work/log"; echo "run.sh: failed: $*"; exit 1; } >&2; }

cat /proc/loadavg | cut -d ' ' -f 1-3 >"$work/load"
step tools/dependencies.sh bench
step cmake --preset release -DODOMD_BENCH=ON
step cmake --build --preset release -j "$(nproc)" --target bench
bin=$PWD/build/release/bin
export TMPDIR=$work # on tmpfs, like the segment

measure() {
  step "$bin/$1" --benchmark_repetitions=$repetitions --benchmark_min_time=$min_time \
    --benchmark_enable_random_interleaving=true --benchmark_report_aggregates_only=true \
    --benchmark_out_format=json --benchmark_out="$work/$1.json"
}
for name in bench_decoder bench_estimator bench_shm_api; do measure $name; done
if [ -x "$bin/bench_iceoryx" ]; then
  iox-roudi -m off -l error >"$work/broker.log" 2>&1 &
  broker=$!
  until grep -qs ready "$work/broker.log"; do
    kill -0 $broker 2>/dev/null || { cat "$work/broker.log"; echo "run.sh: iox-roudi ended"; exit 1; } >&2
    sleep 0.1
  done
  measure bench_iceoryx
  kill $broker && wait $broker || true
  broker=
fi

drive=$work/drive
step "$bin/odom" sim --duration $drive_seconds --out "$drive"
for model in paper full; do
  camera=()
  [ $model != full ] || camera=(--camera "$drive/camera.csv")
  echo $drive_seconds >"$work/replay-$model.txt"
  for _ in $(seq $runs); do
    begin=$(date +%s%N)
    step "$bin/odom" replay --config "$drive/car.toml" --can "$drive/drive.log" "${camera[@]}" \
      --model $model --out "$work/pose.csv"
    echo $(($(date +%s%N) - begin)) >>"$work/replay-$model.txt"
  done
done

python3 tests/bench/beat.py --bin "$bin" --drive "$drive" --runs $runs --seconds $seconds >"$work/beat.json"
python3 tests/bench/report.py "$work"
