#!/usr/bin/env bash
# Runs every check, the long ones too (about 15 minutes on two cores), and writes what they printed
# to docs/verification.md, with the commit and the machine. Fails when a check fails. What takes an hour,
# scenes drawn by the hundred, has a command of its own (below).
#
#     tests/verification.sh [--fast]      --fast leaves out the long ones
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

long=(--include-ignored)
[ "${1:-}" = --fast ] && long=()
printed=$(mktemp)
trap 'rm -f "$printed"' EXIT
failed=0
# All of the workspace, so that nothing is built anew; the tables of these packages are kept.
cargo test --release --workspace --no-fail-fast --tests -- \
    "${long[@]}" --skip draws::hundreds --test-threads=1 --nocapture >"$printed" 2>&1 || failed=1

{
    echo "# Verification"
    echo
    echo "What every check printed, in full; written by \`tests/verification.sh\`, not by hand. A heading is the"
    echo "claim of a test; the test fails when its numbers leave the bounds that stand in its code."
    echo
    echo "* Commit: $(git rev-parse --short HEAD)$(git diff --quiet HEAD || echo ' with changes'), $(date -u +%F)"
    echo "* Machine: $(nproc) cores, $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), $(rustc --version)"
    echo "* Processes, signals, shared memory and files have tests without tables: \`cargo test --release --workspace\`."
    echo "* Scenes drawn at random, and 300 changes of every shipped scene, are a check of an hour:"
    echo "  \`cargo test --release --workspace --test commands -- --ignored draws::hundreds --nocapture --test-threads 1\`."
    awk '
        # Tables stay tables; other lines keep their columns.
        function close_table() {
            if (in_table) print ""
            if (in_text) print "```\n"
            in_table = in_text = 0
        }
        /^ +Running unittests src\/(lib|main)\.rs / {
            close_table(); pending = ""; name = $NF
            sub(/^.*\//, "", name); sub(/-[0-9a-f]+\)$/, "", name); gsub(/_/, "-", name)
            # programs of a library are named sillage-…, and belong to it
            if (name ~ /^sillage-/) next
            package = name
            kept = package ~ /^(fluid-solver|particle-solver|coupler|tests)$/
            if (kept && package != last) { print ""; print "## " package; last = package }
            next
        }
        /^ +Running / { close_table(); pending = ""; next }
        !kept { next }
        /^test .* \.\.\. / {
            name = $2; sub(/^.*::/, "", name); gsub(/_/, " ", name)
            result = $0; sub(/^test .* \.\.\. /, "", result)
            pending = name; printed_any = 0
            line = result
            if (line == "ok") { next }
            if (line == "FAILED") { print ""; print "### " toupper(substr(name,1,1)) substr(name,2); print ""; print "**FAILED**"; next }
            $0 = line
        }
        /^(ok|FAILED)$/ {
            close_table()
            if ($0 == "FAILED") print "**FAILED**"
            pending = ""; next
        }
        /^(running|test result|$)/ { if (!/^$/) { close_table(); pending = "" } next }
        pending != "" {
            if (!printed_any) {
                print ""; print "### " toupper(substr(pending,1,1)) substr(pending,2); print ""
                printed_any = 1
            }
            if (/^\|/) {
                if (in_text) close_table()
                print
                if (!in_table) {
                    row = $0; gsub(/[^|]+/, " --- ", row); print row; in_table = 1
                }
            } else {
                if (in_table) close_table()
                if (!in_text) print "```text"
                in_text = 1
                print
            }
        }
    ' "$printed"
} | cat -s >docs/verification.md
exit "$failed"
