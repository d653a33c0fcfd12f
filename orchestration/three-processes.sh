#!/usr/bin/env bash
# Starts the processes of a run by hand, without the orchestrator, and shows how each ended:
#
#   orchestration/three-processes.sh scenes/cloud.toml by-hand
#
# They find each other by the name in SILLAGE_RUN alone, in any order (protocol/README.md). Without
# an orchestrator the coupler writes one JSON object a step to its standard output.
set -euo pipefail

scene=${1:?usage: $0 SCENE [FOLDER] [--set KEY=VALUE]…}
folder=${2:-by-hand}
shift $(($# < 2 ? $# : 2))
root=$(cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." && pwd)
programs=${SILLAGE_PROGRAMS:-${CARGO_TARGET_DIR:-$root/target}/release}

# The resolved scene and its grains, and which processes it needs.
seats=$("$programs/sillage" plan "$scene" --out "$folder" --json "$@" |
    sed -n 's/.*"seat": "\(.*\)".*/\1/p')

export SILLAGE_RUN="hand$$"
declare -A process
for seat in $seats; do
    case $seat in
    coupler)
        "$programs/sillage-coupler" --scene "$folder/scene.json" \
            >"$folder/steps.jsonl" 2>"$folder/coupler.log" &
        ;;
    *)
        "$programs/sillage-$seat" >"$folder/$seat.log" 2>&1 &
        ;;
    esac
    process[$seat]=$!
    echo "$seat: process ${process[$seat]}"
done

worst=0
for seat in $seats; do
    code=0
    wait "${process[$seat]}" || code=$?
    echo "$seat: exit code $code"
    worst=$((code > worst ? code : worst))
done
echo "$folder/steps.jsonl: $(wc -l <"$folder/steps.jsonl") steps"
exit "$worst"
