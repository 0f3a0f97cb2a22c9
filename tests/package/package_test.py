#!/usr/bin/env python3
"""The Debian packages, as cpack makes them: what they ask for, installed, run, and removed.

    package_test.py BUILD_DIR SOURCE_DIR SCRATCH_DIR

dpkg installs them below SCRATCH_DIR with a copy of this machine's list of packages, so that what they depend on is checked and
nothing else is touched; no root is needed. Exit status 77 where the tools are missing.
"""
import gzip
import os
import pathlib
import re
import shutil
import subprocess
import sys

TOOLS = ("dpkg", "dpkg-deb", "dpkg-shlibdeps", "cpack", "readelf", "file")
failures = []


def expect(condition, what):
    if not condition:
        failures.append(what)


def run(*words, **more):
    result = subprocess.run([str(word) for word in words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            text=True, timeout=600, check=False, **more)
    if result.returncode != 0:
        print(result.stdout)
        sys.exit(f"{' '.join(map(str, words))}: exit status {result.returncode}")
    return result.stdout


class Dpkg:
    """dpkg on a folder of its own, in the knowledge of what this machine has installed."""

    def __init__(self, scratch):
        self.root, admin = scratch / "root", scratch / "dpkg"
        self.root.mkdir()
        shutil.copytree("/var/lib/dpkg", admin, ignore=shutil.ignore_patterns("lock*", "*-old"))
        # The packages' scripts do nothing but call ldconfig, which has nothing to do here.
        (scratch / "bin").mkdir()
        (scratch / "bin/ldconfig").symlink_to("/bin/true")
        self.words = ["dpkg", "--force-not-root", "--force-script-chrootless", "--no-triggers", f"--instdir={self.root}", f"--admindir={admin}", f"--log={scratch / 'log'}"]
        self.environment = {**os.environ, "PATH": f"{scratch}/bin:{os.environ['PATH']}:/usr/sbin:/sbin", "LC_ALL": "C"}

    def __call__(self, *words):
        return run(*self.words, *words, env=self.environment)


def needed(path):
    """Shared libraries that a program or module names."""
    return re.findall(r"\(NEEDED\).*\[(.*)\]", run("readelf", "-d", path))


def owners(library):
    """Packages of this machine that hold a shared library."""
    found = subprocess.run(["dpkg", "-S", f"*/{library}"], capture_output=True, text=True, check=False).stdout
    return {line.split(":")[0] for line in found.splitlines()}


def check_dependencies(package, name, folder):
    """Every library that something in the package names comes with a package that it depends on."""
    depends = run("dpkg-deb", "-f", package, "Depends")
    told = {re.split(r"[ (:]", word.strip())[0] for words in depends.split(",") for word in words.split("|")}
    for path in [p for p in folder.rglob("*") if p.is_file() and p.read_bytes()[:4] == b"\x7fELF"]:
        for library in needed(path):
            owned = owners(library)
            # A library that is split off another (libgcc-s1 of libc6) may come by the other.
            expect(not owned or owned & told or library.startswith(("ld-linux", "libgcc_s", "libm.", "libpthread", "libdl")),
                   f"{name}: {path.name} needs {library} of {sorted(owned)}, the package depends on {sorted(told)}")
    return told


def check_program(root, source, work):
    program = root / "usr/bin/trunnion"
    share = root / "usr/share/trunnion"
    version = run(program, "--version")
    expect(re.fullmatch(r"trunnion \d+\.\d+\.\d+\n", version), f"--version says {version!r}")
    for folder in ("machines", "samples"):
        for path in sorted((source / folder).rglob("*")):
            inside = share / folder / path.relative_to(source / folder)
            if path.is_file() and path.name != "demo.sh":
                expect(inside.is_file() and inside.read_bytes() == path.read_bytes(), f"{inside} is not that of the source")
    for machine in sorted((share / "machines").glob("*.toml")):
        run(program, "doctor", "--machine", machine)
    sample = share / "samples/calibrate"
    run(program, "identify", "--machine", sample / "machine.toml", "--observations", sample / "replica.csv", "-o", "model.json", cwd=work)
    piece = share / "samples/predict/piece.toml"
    run(program, "predict", "--machine", sample / "machine.toml", "--model", "model.json", "--piece", piece, "--draws", "5", "-o", "piece", cwd=work)
    has_modeller = bool(list(root.rglob("trunnion_brep.so")))
    expect((work / "piece/part.step").exists() == has_modeller, "part.step: the solid modeller of the package is not found")
    return has_modeller


def check_pages(root, built):
    """A manual page for the program and one for each command; completion that bash takes."""
    program = root / "usr/bin/trunnion"
    commands = re.findall(r"^  ([a-z]+) {2,}", run(program, "--help").split("Subcommands:")[-1], re.M)
    expect(len(commands) >= 12, f"commands of --help: {commands}")
    if (built / "share/trunnion.1").exists():
        for page in ["trunnion", *(f"trunnion-{command}" for command in commands)]:
            files = list((root / "usr/share/man/man1").glob(f"{page}.1*"))
            text = b"".join(gzip.decompress(f.read_bytes()) if f.suffix == ".gz" else f.read_bytes() for f in files)
            expect(len(files) == 1 and b".TH" in text and b"trunnion" in text, f"the manual page {page}.1")
    bash = root / "usr/share/bash-completion/completions/trunnion"
    for path in (bash, root / "usr/share/zsh/site-functions/_trunnion", root / "usr/share/fish/vendor_completions.d/trunnion.fish"):
        expect(path.is_file() and path.stat().st_size > 1000, f"{path}")
    if shutil.which("bash"):
        expect("trunnion" in run("bash", "--norc", "-c", f"source '{bash}' && complete -p trunnion"), "bash takes the completion")


def check_module(root, python, source):
    folder = next(root.glob("usr/lib/python3*/*-packages"))
    code = ("import sys, trunnion; m = trunnion.Machine(sys.argv[1]); o = trunnion.Observations(sys.argv[2], m); "
            "print(trunnion.__file__, trunnion.identify(m, o).rank)")
    sample = source / "samples/calibrate"
    said = run(python, "-c", code, sample / "machine.toml", sample / "replica.csv",
               env={**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"})
    expect(said.startswith(str(folder)) and int(said.split()[-1]) > 100, f"the module says {said!r}")


def main():
    build, source, scratch = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    missing = [tool for tool in TOOLS if shutil.which(tool) is None]
    if missing:
        print(f"left out: {', '.join(missing)} missing (cmake/install-dependencies.sh package)")
        return 77
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    run("cpack", "-G", "DEB", "-B", scratch / "made", cwd=build)
    packages = {p.name.split("_")[0]: p for p in (scratch / "made").glob("*.deb")}
    expect("trunnion" in packages, f"packages made: {sorted(packages)}")
    dpkg = Dpkg(scratch)
    dpkg("--install", *packages.values())
    for name, package in packages.items():
        content = scratch / name
        run("dpkg-deb", "-x", package, content)
        told = check_dependencies(package, name, content)
        expect("libc6" in told, f"{name}: depends on {sorted(told)}")
        print(f"{name}: {package.stat().st_size / 1e6:.1f} MB, depends on {', '.join(sorted(told))}")
    work = scratch / "work"
    work.mkdir()
    solid = check_program(dpkg.root, source, work)
    check_pages(dpkg.root, build)
    if "python3-trunnion" in packages:
        check_module(dpkg.root, "/usr/bin/python3", source)
    print(f"installed, run{' with its solid modeller' if solid else ''}, removed:", len([p for p in dpkg.root.rglob('*') if p.is_file()]), "files")
    dpkg("--purge", *packages)
    left = [str(p.relative_to(dpkg.root)) for p in dpkg.root.rglob("*")]
    expect(not left, f"left behind: {left[:10]}")
    print("\n".join(failures) or "all as it should be")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
