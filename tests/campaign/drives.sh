#!/bin/bash
# The recorded drives, each through every model: tables of errors in Markdown, as they stand in
# docs/evaluation.md. First by dead reckoning from the reference's first pose; then with the camera's
# poses, against the reference as it is.
#
#   ODOMD_DRIVES=DIRECTORY tests/campaign/drives.sh [MODEL...]
#
# Configurations are tests/data/drives/SET.toml; SET is how the drive's folder begins. The camera's
# lever arm there is the reference's too. ODOM=FILE: that program.
set -euo pipefail
cd "$(dirname "$0")/../.."

odom=${ODOM:-build/release/bin/odom}
drives=${ODOMD_DRIVES:?set it to the folder of recorded drives}
models=("${@:-kinematic_printed}")
[ $# -gt 0 ] || models=(kinematic_printed kinematic paper full)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

command -v jq > /dev/null || { echo "drives: jq is missing: tools/dependencies.sh campaign" >&2; exit 1; }
[ -x "$odom" ] || { echo "drives: $odom is missing: cmake --preset release && cmake --build --preset release" >&2; exit 1; }

lever_arm() {
  python3 -c 'import sys, tomllib
arm = tomllib.load(open(sys.argv[1], "rb")).get("camera", {}).get("lever_arm", [0, 0, 0])
print(*arm, sep=",")' "$1"
}

# errors FOLDER ALIGN [REPLAY OPTION...]: replays a drive through all models; leaves poses in
# $work/MODEL.csv and their errors in $work/errors.json.
errors() {
  local folder=$1 align=$2 poses=() config arm model
  shift 2
  config=tests/data/drives/$(basename "${folder%%_*}").toml
  arm=$(lever_arm "$config")
  for model in "${models[@]}"; do
    "$odom" replay --config "$config" --dbc "$folder/car.dbc" --can "$folder/drive.log" --model "$model" \
      "$@" --out "$work/$model.csv" 2> "$work/$model.log" || { cat "$work/$model.log" >&2; exit 1; }
    poses+=(--pose "$work/$model.csv")
  done
  "$odom" evaluate --reference "$folder/truth.csv" "${poses[@]}" --lever-arm="$arm" --align "$align" \
    --json > "$work/errors.json" 2> "$work/evaluate.log" || { cat "$work/evaluate.log" >&2; exit 1; }
}

remark_on() {
  local stopped
  stopped=$(awk -F, '$11 == "fault" {print NR; exit}' "$work/$1.csv")
  [ -z "$stopped" ] || echo "stopped after $((stopped / 200)) s: the car reverses"
}

# rows DRIVE COLUMNS: a row a model. COLUMNS is jq: an estimate's errors -> the cells, [value, decimals] each.
rows() {
  local i
  for i in "${!models[@]}"; do
    jq -r --argjson i "$i" --arg drive "$1" --arg model "${models[$i]}" --arg remark "$(remark_on "${models[$i]}")" '
      def rounded: (pow(10; .[1])) as $n | .[0] * $n | round / $n | tostring;
      def degrees: . * 57.29577951;
      .estimates[$i] | [['"$2"'] | .[] | rounded] as $cells |
      "| " + ([$drive, $cells[0], $model, $cells[1:][], $remark] | join(" | ")) + " |"' "$work/errors.json"
  done
}

echo "Dead reckoning, $(date +%F):"
echo
echo "| drive | path [m] | model | end [m] | cm/m | heading end [°] | position rms [m] | 35 ms mean [mm] | remark |"
echo "|---|--:|---|--:|--:|--:|--:|--:|---|"
for folder in "$drives"/*/; do
  folder=${folder%/}
  [ -f "$folder/drive.log" ] || continue
  errors "$folder" first --initial="$(awk -F, 'NR == 2 {print $2 "," $3 "," $4}' "$folder/truth.csv")"
  rows "$(basename "$folder")" '[.path_length, 1], [.end_error, 2], [.end_error_cm_per_m, 2],
    [(.heading.end | degrees), 1], [.position.rms, 2], [.error_35ms.position.mean * 1000, 2]'
done

echo
echo "With the camera, $(date +%F):"
echo
echo "| drive | path [m] | model | position rms [mm] | position max [mm] | yaw rms [°] | NEES | remark |"
echo "|---|--:|---|--:|--:|--:|--:|---|"
for folder in "$drives"/*/; do
  folder=${folder%/}
  [ -f "$folder/camera.csv" ] || continue
  errors "$folder" none --camera "$folder/camera.csv"
  rows "$(basename "$folder")" '[.path_length, 1], [.position.rms * 1000, 1], [.position.max * 1000, 0],
    [(.heading.rms | degrees), 2], [(.nees.mean // 0), 1]'
done
