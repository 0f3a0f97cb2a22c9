#!/usr/bin/env bash
# Installs the Debian packages that Trunnion is built from. Asks nothing; does nothing where all of them are there.
#
#   cmake/install-dependencies.sh [GROUP …]
#
# Without a group: what building and testing need. Further groups:
#   linuxcnc   the LinuxCNC interpreter, simulator and headers, against which programs and tables are tested
#   browser    headless Chromium, for the tests of the report
#   python     pybind11, numpy, pytest and matplotlib: the Python module, its test and its example
#   shells     help2man for the manual pages; fish and zsh, which complete the program's words in a test
#   postgres   PostgreSQL's client and server: the history of a plant, and its test
#   fleet      GNU parallel, and a Slurm that a test starts: the fleet on a workstation and on a cluster
#   package    what cpack needs for the Debian package
#   readers    FreeCAD, in which the STEP of a predicted piece is opened
#   develop    clang, its tools and sanitizer run-times, valgrind, doxygen: presets tidy and fuzz, the headers as a site
set -euo pipefail

packages_of() {
  case "$1" in
    build)
      echo g++ cmake ninja-build ccache mold python3 \
        libeigen3-dev libcgal-dev libboost-dev libcli11-dev libtomlplusplus-dev nlohmann-json3-dev \
        libocct-data-exchange-dev libsqlite3-dev pkg-config libgtest-dev libgmock-dev librapidcheck-dev libbenchmark-dev
      ;;
    linuxcnc) echo linuxcnc-uspace linuxcnc-uspace-dev ;;
    python) echo python3-dev pybind11-dev python3-numpy python3-pytest python3-matplotlib ;;
    shells) echo help2man fish zsh ;;
    browser)
      # Node.js of another origin brings its own npm, which that of Debian refuses.
      echo chromium
      command -v node >/dev/null || echo nodejs
      command -v npm >/dev/null || echo npm
      ;;
    postgres) echo libpq-dev postgresql ;;
    fleet) echo parallel slurmctld slurmd slurm-client munge ;;
    package) echo dpkg-dev file ;;
    readers) echo freecad-python3 freecad-common ;;
    develop) echo clang clang-tidy clang-format libclang-rt-14-dev valgrind doxygen ;;
    *)
      echo "install-dependencies.sh: '$1' is no group; groups are linuxcnc, browser, python, shells, postgres, fleet, package, readers, develop" >&2
      return 2
      ;;
  esac
}

missing=()
for group in build "$@"; do
  list=$(packages_of "$group") || exit 2
  for package in $list; do
    if ! command -v dpkg-query >/dev/null; then
      echo "install-dependencies.sh: this is no Debian; its packages would be: $list" >&2
      break
    fi
    status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
    [ "$status" = installed ] || missing+=("$package")
  done
done
[ ${#missing[@]} -gt 0 ] || exit 0

as_root=(env)
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "install-dependencies.sh: as root, please: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo env)
fi
echo "install-dependencies.sh: installing ${missing[*]}" >&2
apt=("${as_root[@]}" DEBIAN_FRONTEND=noninteractive apt-get -qq -y -o Acquire::Retries=3 -o Dpkg::Use-Pty=0)
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { "${apt[@]}" update && "${apt[@]}" install --no-install-recommends "${missing[@]}"; } </dev/null >"$log" 2>&1; then
  cat "$log" >&2
  exit 1
fi
