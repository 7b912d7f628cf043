#!/usr/bin/env bash
# Stylet's own answers, by its shipped commands, ready for score.py:
#   run_stylet.sh RESULTS [STYLET]     # the program, `stylet` unless told
# A time is that of the whole command: start, reading, solving and writing.
set -euo pipefail

here=$(cd "$(dirname "$0")" && pwd)
out=${1:?a folder for the results is needed}
stylet=${2:-stylet}
mkdir -p -- "$out"

echo case,seconds >"$out/times.csv"
for folder in "$here"/cases/*/; do
    name=$(basename "$folder")
    start=$(date +%s%N)
    if [ -e "$folder/motion.csv" ]; then
        "$stylet" force "$folder/case.json" --trajectory "$folder/motion.csv" >"$out/$name.csv"
    else
        "$stylet" field "$folder/case.json" --tolerance 0.001 --csv >"$out/$name.csv"
    fi
    end=$(date +%s%N)
    echo "$name,$(((end - start) / 1000000))e-3" >>"$out/times.csv"
done
