#!/bin/bash
# The recorded drives, each through every model by dead reckoning from the reference's first pose: a
# table of errors in Markdown, as it stands in docs/evaluation.md.
#
#   ODOMD_DRIVES=DIRECTORY tests/campaign/drives.sh [MODEL...]
#
# Configurations are tests/data/drives/SET.toml; SET is how the drive's folder begins. The camera's
# lever arm there is the reference's too.
set -euo pipefail
cd "$(dirname "$0")/../.."

odom=build/release/bin/odom
drives=${ODOMD_DRIVES:?set it to the folder of recorded drives}
models=("${@:-kinematic_printed}")
[ $# -gt 0 ] || models=(kinematic_printed kinematic paper)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

command -v jq > /dev/null || { echo "drives: jq is missing: tools/dependencies.sh campaign" >&2; exit 1; }
[ -x "$odom" ] || { echo "drives: $odom is missing: cmake --preset release && cmake --build --preset release" >&2; exit 1; }

echo "Dead reckoning, $(date +%F):"
echo
echo "| drive | path [m] | model | end [m] | cm/m | heading end [°] | position rms [m] | 35 ms mean [mm] | remark |"
echo "|---|--:|---|--:|--:|--:|--:|--:|---|"
for log in "$drives"/*/drive.log; do
  folder=$(dirname "$log")
  drive=$(basename "$folder")
  config=tests/data/drives/${drive%%_*}.toml
  initial=$(awk -F, 'NR == 2 {print $2 "," $3 "," $4}' "$folder/truth.csv")
  arm=$(sed -n 's/^lever_arm = \[\(.*\)\].*/\1/p' "$config" | tr -d ' ')

  poses=()
  for model in "${models[@]}"; do
    "$odom" replay --config "$config" --dbc "$folder/car.dbc" --can "$log" --model "$model" \
      --initial="$initial" --out "$work/$model.csv" 2> "$work/$model.log" || { cat "$work/$model.log" >&2; exit 1; }
    poses+=(--pose "$work/$model.csv")
  done
  "$odom" evaluate --reference "$folder/truth.csv" "${poses[@]}" --lever-arm="${arm:-0,0,0}" --json \
    > "$work/errors.json" 2> "$work/evaluate.log"

  for i in "${!models[@]}"; do
    model=${models[$i]}
    stopped=$(awk -F, '$11 == "fault" {print NR; exit}' "$work/$model.csv")
    remark=""
    [ -z "$stopped" ] || remark="stopped after $((stopped / 200)) s: the car reverses"
    jq -r --argjson i "$i" --arg drive "$drive" --arg model "$model" --arg remark "$remark" '
      def round_to(n): . * pow(10; n) | round / pow(10; n);
      .estimates[$i] | "| \($drive) | \(.path_length | round_to(1)) | \($model) | \(.end_error | round_to(2)) | " +
        "\(.end_error_cm_per_m | round_to(2)) | \(.heading.end * 57.29577951 | round_to(1)) | " +
        "\(.position.rms | round_to(2)) | \(.error_35ms.position.mean * 1000 | round_to(2)) | \($remark) |"' \
      "$work/errors.json"
  done
done
