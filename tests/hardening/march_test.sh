#!/usr/bin/env bash
# The program built for newer processors (fused multiply-add, wider vectors) agrees with the usual one to the stated digits.
#
#   march_test.sh PROGRAM SOURCE_DIR BUILD_DIR [LEVEL]
#
# Exit status 77 where this processor has not what the level asks for.
set -euo pipefail
program=$1 source=$2 build=$3 level=${4:-x86-64-v3}
if ! /lib64/ld-linux-x86-64.so.2 --help 2>/dev/null | grep -q "$level (supported"; then
  echo "left out: this processor is no $level"
  exit 77
fi
cmake -S "$source" -B "$build" -G Ninja -D CMAKE_BUILD_TYPE= -D "CMAKE_CXX_FLAGS=-O2 -march=$level" -D CMAKE_UNITY_BUILD=ON \
  -D CMAKE_UNITY_BUILD_BATCH_SIZE=8 -D BUILD_TESTING=OFF -D TRUNNION_PYTHON=OFF >/dev/null
cmake --build "$build" --target trunnion >"$build/log" || { tail -n 50 "$build/log"; exit 1; }
python3 "$source/tests/hardening/environment_test.py" "$program" "$source" "$build/trunnion"
