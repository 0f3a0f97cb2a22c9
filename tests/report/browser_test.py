"""The page of evidence in headless Chromium: everything the samples give, rendered, asked and moved.

    browser_test.py TRUNNION SOURCE FOLDER        exit status 77: no Chromium, Node.js or playwright-core"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

PLAYWRIGHT = "playwright-core@1.49.1"


def results(trunnion, source, folder):
    """One of each result, of the sample machine."""
    samples, machine = source / "samples", source / "samples/calibrate/machine.toml"

    def run(*words, drafts=False):
        done = subprocess.run([trunnion, *map(str, words)], capture_output=True, text=True)
        assert done.returncode == 0 or (drafts and done.returncode == 1), done.stderr

    run("identify", "--machine", machine, "--observations", samples / "calibrate/replica.csv", "-o", folder / "model.json")
    run("close", "--machine", machine, "--observations", samples / "calibrate/replica.csv", "-o", folder / "closed")
    run("tables", "--machine", machine, "--model", folder / "model.json", "--controller", "linuxcnc", "-o", folder / "tables")
    run("tables", "--machine", machine, "--model", folder / "model.json", "--controller", "sinumerik-840d", "-o",
        folder / "drafts", drafts=True)
    run("correct", "--machine", machine, "--model", folder / "model.json", "--job", samples / "correct/job.toml",
        samples / "correct/part.ngc", "-o", folder / "corrected.ngc", "--report", folder / "correction.json")
    run("predict", "--machine", machine, "--model", folder / "model.json", "--piece", samples / "predict/piece.toml",
        "--tables", folder / "tables", "-o", folder / "piece")
    run("report", folder, "-o", folder / "report.html")
    return folder / "report.html"


def main():
    trunnion, source, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if not chromium or not shutil.which("node") or not shutil.which("npm"):
        return 77
    shutil.rmtree(folder / "results", ignore_errors=True)
    (folder / "results").mkdir(parents=True)
    if not (folder / "node_modules/playwright-core").is_dir():
        (folder / "package.json").write_text('{"private": true}\n')
        if subprocess.run(["npm", "install", "--no-audit", "--no-fund", PLAYWRIGHT], cwd=folder,
                          capture_output=True).returncode != 0:
            return 77
    page = results(trunnion, source, folder / "results")
    assert page.stat().st_size < 3_000_000, page.stat().st_size
    outside = re.findall(r'(?:src|href)="(?!#)[^"]*"', page.read_text())
    assert not outside, outside
    script = source / "tests/report/browser_test.mjs"
    shutil.copy(script, folder / "browser_test.mjs")  # so that it finds the module beside it
    done = subprocess.run(["node", "browser_test.mjs", page, chromium], cwd=folder, text=True, capture_output=True,
                          env=dict(os.environ))
    print(done.stdout, done.stderr)
    return done.returncode


if __name__ == "__main__":
    sys.exit(main())
