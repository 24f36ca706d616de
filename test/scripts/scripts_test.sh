#!/usr/bin/env bash
# scripts/common.sh and check_source.sh on other machines: slow ones, small ones, ones with older tools.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "$*" >&2; exit 1; }
expect() { [ "$2" = "$3" ] || fail "$1: expected '$3', got '$2'"; }

. "$here/../../scripts/common.sh"

# Where nothing can be drawn in place, the first and the last line are shown, the others now and then; the log has all.
progress_seconds=1000
ninja_output() { printf '[%s/3] Building CXX object\n' 1 2 3; }
expect "progress of ninja" "$(ninja_output | show_progress "$work/log")" \
  $'[1/3] Building CXX object\n[3/3] Building CXX object'
expect "log of ninja" "$(cat "$work/log")" "$(ninja_output)"
progress_seconds=0
apt_output() { printf '%s\n' "Get:1 a" "Get:2 b" "Reading" "Unpacking a (1) ..." "Unpacking b (1) ..." "Setting up b (1) ..."; }
expect "progress of apt-get" "$(apt_output | show_progress "$work/log" 2)" \
  $'[1/2] fetched\n[2/2] fetched\n[1/2] unpacked\n[2/2] unpacked\n[1/2] set up'
expect "progress of nothing" "$(show_progress "$work/log" </dev/null)" ""

# On a terminal one line moves.
command -v script >/dev/null && expect "on a terminal" "$(
  script -qec "bash -c '. $here/../../scripts/common.sh; printf \"[%s/2] x\\n\" 1 2 | show_progress $work/log'" /dev/null | tr -d '\n' | tail -c 24
)" $'\r\033[K[1/2] x\r\033[K[2/2] x\r'

# A failing command stays a failure behind the display.
! (exit 3) | show_progress "$work/log" || fail "a failure was lost"

expect "cores decide" "$(compilers 4 16000000)" 4
expect "memory decides" "$(compilers 8 4000000)" 3
expect "at least one" "$(compilers 4 300000)" 1

# --help prints the usage, and installs and builds nothing.
for script in demo test lint fuzz soak trust arm64; do
  help=$("$here/../../scripts/$script" --help) || fail "scripts/$script --help failed"
  case $help in *"scripts/$script "*) ;; *) fail "scripts/$script --help says '$help'" ;; esac
done

# An option is not guessed by its beginning.
(cd "$here/../.." && for program in $(grep -l ArgumentParser scripts/*.py examples/*.py) "scripts/evaluate_report.py run"; do
  ! /usr/bin/python3 $program --hel >/dev/null 2>&1 || fail "$program takes --hel for --help"
done)

# scripts/trust measures, and replaces tables only in the documents that it is given.
mkdir -p "$work/trust/bin" "$work/trust/doc/measured" "$work/data"
cp -r "$here/../../scripts" "$work/trust/"
printf '<!-- begin of the recordings -->\nold\n<!-- end of the recordings -->\n' | tee "$work/trust/doc/measured/trust.md" >"$work/other.md"
cat >"$work/trust/bin/rosrun" <<'PROGRAM'
#!/usr/bin/env bash
[ "$2" = render_scene ] && { mkdir -p "$3"; exit; }
[ "$3" = odometry ] && exit
while [ $# -gt 1 ]; do [ "$1" = --out ] && out=$2; shift; done
mkdir -p "$out"
echo '{"unit": 0, "runs": [{"kind": "real", "set": "s", "gap": 1, "method": "m", "status": "RANSAC_FAILED", "stationary": false, "inliers": 0,
  "matches_gms": 0, "reliability": [0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0], "reference": "a",
  "current": "b", "reference_stamp": 0, "stamp": 1, "truth": {"has_pose": true, "translation_m": [0, 0, 1], "moved": true}}]}' |
  tr -d '\n' >"$out/measurements.jsonl"
PROGRAM
chmod +x "$work/trust/bin/rosrun"
for options in "" "--into $work/other.md"; do
  python3 -c 'import numpy' 2>/dev/null || break  # the report needs it
  PATH=$work/trust/bin:$PATH "$work/trust/scripts/trust" "$work/data" --out "$work/trust/out" $options >"$work/log" 2>&1 ||
    fail "scripts/trust: $(cat "$work/log")"
  grep -qx old "$work/trust/doc/measured/trust.md" || fail "scripts/trust replaced tables that it was not asked for"
  grep -qx old "$work/other.md" && replaced=no || replaced=yes
  expect "tables replaced with '$options'" "$replaced" "$([ -n "$options" ] && echo yes || echo no)"
done

# It measures motions alone, with both shutters, and refuses what is no file.
! "$work/trust/scripts/trust" --motion "$work/none.txt --from 3" >"$work/log" 2>&1 || fail "scripts/trust took no file"
expect "a motion that is no file" "$(cat "$work/log")" "trust: --motion: '$work/none.txt' is no file"
! "$work/trust/scripts/trust" --out "$work/trust/out" >"$work/log" 2>&1 || fail "scripts/trust took no input"
touch "$work/hand.txt"
if python3 -c 'import numpy' 2>/dev/null; then
  PATH=$work/trust/bin:$PATH "$work/trust/scripts/trust" --out "$work/trust/alone" --motion "$work/hand.txt --from 3" >"$work/log" 2>&1 ||
    fail "scripts/trust --motion: $(cat "$work/log")"
  expect "motions rendered" "$(cd "$work/trust/alone" && cat motion/*/done)" \
    "--rate 20 --readout 0 --trajectory $work/hand.txt --from 3
--rate 20 --readout 0.4 --trajectory $work/hand.txt --from 3"
  expect "only motions" "$(ls "$work/trust/alone")" motion
fi

# Styles are judged by the tools that they were written for.
for tool in clang-format clang-tidy; do
  printf '#!/bin/sh\n[ "$1" = --version ] && echo "Debian %s version 11.0.1-2" && exit\nexit 1\n' "$tool" >"$work/$tool"
  chmod +x "$work/$tool"
done
for check in format tidy; do
  status=0
  PATH=$work:$PATH bash "$here/../check_source.sh" "$check" "$work" >/dev/null || status=$?
  expect "$check with version 11" "$status" 77
done
