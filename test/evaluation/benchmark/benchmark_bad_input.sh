#!/bin/sh
# Every bad input ends the benchmark with one line on stderr and exit status 2. usage: benchmark_bad_input.sh PROGRAM
program=$1

refuses() {
  errors=$("$program" "$@" 2>&1 >/dev/null)
  status=$?
  if [ "$status" -ne 2 ] || [ "$(printf '%s\n' "$errors" | wc -l)" -ne 1 ]; then
    printf 'benchmark %s: status %s, said: %s\n' "$*" "$status" "$errors"
    exit 1
  fi
  printf 'benchmark %s: %s\n' "$*" "$errors"
}

refuses /no/such/folder
refuses --features many
refuses --features 0
refuses --threads some
refuses --model homography
refuses --method unheard_of
refuses --pairs 0
refuses --out /no/such/folder/file
refuses --unknown
