#!/usr/bin/env python3
"""What `trunnion close --predict` says of a frustum is what `trunnion predict` says by the models that it wrote.

    close_predicts_test.py PROGRAM SOURCE_DIR SCRATCH_DIR

The calibration's effect (a backlash of C) is undeclared: the maps alone, and a correction by them, leave what it does.
A piece beyond the probed tilts leaves the prediction out with a warning, and the search stands.
"""
import json
import pathlib
import shutil
import subprocess
import sys


def main():
    program, source, scratch = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    machine, piece = source / "samples/calibrate/machine.toml", source / "samples/predict/piece.toml"
    readings = [f"--observations={source}/samples/close/calibration.csv", f"--verification={source}/samples/close/later.csv"]

    def run(*arguments):
        done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == 0, (arguments, done.stderr)
        return done

    run("close", "--quiet", "--machine", machine, *readings, "--predict", piece, "-o", scratch / "closed")
    closure = json.loads((scratch / "closed/closure.json").read_text())
    outlook = closure["predicted_piece"]
    run("predict", "--quiet", "--machine", machine, "--model", scratch / "closed/model.json", "--piece", piece, "-o",
        scratch / "predicted")
    predicted = json.loads((scratch / "predicted/prediction.json").read_text())
    by_predict = max(h["lsc_um"] for h in predicted["uncompensated"]["heights"])
    found = outlook["not_corrected"]["after"]
    assert abs(found["roundness_um"] - by_predict) < 1e-3, (found, by_predict)
    assert abs(found["form_um"] - predicted["uncompensated"]["form_um"]) < 1e-3, (found, predicted["uncompensated"]["form_um"])
    left = {stage: outlook["corrected"][stage]["roundness_um"] for stage in ("before", "after")}
    assert left["after"] < 0.01 < 0.1 < left["before"], left
    assert str(piece.name) in closure["inputs_sha256"], closure["inputs_sha256"]

    steep = scratch / "steep.toml"
    steep.write_text(piece.read_text().replace("tilt_deg = 10", "tilt_deg = 88"))
    done = run("close", "--machine", machine, *readings, "--predict", steep, "-o", scratch / "steep")
    assert "the prediction is left out" in done.stderr and "steep.toml: " in done.stderr, done.stderr
    assert "predicted_piece" not in json.loads((scratch / "steep/closure.json").read_text())


if __name__ == "__main__":
    main()
