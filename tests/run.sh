#!/usr/bin/env bash
# Sets up, builds and tests, from a bare clone on. No display and no answers are needed.
#
#   tests/run.sh [--slow] [CTEST-OPTION …]
#
# --slow also runs the long sweeps (label slow), then all but these under the address and undefined-behaviour sanitizers, and
# what runs on several threads under the thread sanitizer. Whatever follows goes to ctest, e.g. `-R errormap`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

slow=false
selection=(--label-exclude slow)
groups=()
if [ "${1:-}" = --slow ]; then
  slow=true
  selection=()
  groups=(develop postgres fleet)
  shift
fi

cmake/install-dependencies.sh
cmake/install-dependencies.sh "${groups[@]}" ||
  echo "tests/run.sh: valgrind, doxygen, PostgreSQL, GNU parallel and Slurm cannot all be installed here; the tests that need them will be skipped" >&2
cmake/install-dependencies.sh linuxcnc ||
  echo "tests/run.sh: LinuxCNC cannot be installed here; the tests that need it will be skipped" >&2
{ cmake/install-dependencies.sh browser && tests/report/install.sh build/test/browser; } ||
  echo "tests/run.sh: no browser can be installed here; the tests that need it will be skipped" >&2
cmake/install-dependencies.sh python ||
  echo "tests/run.sh: the packages of the Python module cannot be installed here; it is left out" >&2
cmake/install-dependencies.sh shells ||
  echo "tests/run.sh: help2man, fish and zsh cannot be installed here; what needs them will be skipped" >&2
cmake/install-dependencies.sh package ||
  echo "tests/run.sh: what cpack needs cannot be installed here; the test of the packages will be skipped" >&2

unset DISPLAY WAYLAND_DISPLAY
cmake --preset test
cmake --build --preset test
ctest --preset test --parallel "$(nproc)" "${selection[@]}" "$@" </dev/null
if ! "$slow"; then exit 0; fi

# Without the system's random placement of memory, which not every version of these sanitizers can do with.
fixed_addresses=(setarch "$(uname -m)" --addr-no-randomize)
"${fixed_addresses[@]}" true 2>/dev/null || fixed_addresses=()
cmake --preset asan
cmake --build --preset asan
"${fixed_addresses[@]}" ctest --preset asan --parallel "$(nproc)" --label-exclude slow "$@" </dev/null

# The pipeline of correct, the envelope and draws of predict, and the progress that is told beside all of them.
cmake --preset tsan
cmake --build --preset tsan --target postproc_test testpiece_test progress_test
"${fixed_addresses[@]}" ctest --preset tsan --parallel "$(nproc)" --label-regex threads --no-tests=error </dev/null
