#!/usr/bin/env python3
"""What `trunnion evaluate` promises: evaluate_test.py PROGRAM SHARED_FOLDER (machine.toml, model.json)."""
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

PROGRAM, SHARED = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
HEADER = "A_deg,C_deg,x_mm,y_mm,z_mm"
RESULTS = "dx_um,dy_um,dz_um,Dx_um,Dy_um,Dz_um,Da_urad,Db_urad,Dc_urad".split(",")


def evaluate(folder, positions, *options, model=None, status=0):
    (folder / "p.csv").write_text(positions)
    (folder / "m.json").write_text(json.dumps(model or json.loads((SHARED / "model.json").read_text())))
    command = [PROGRAM, "evaluate", "--machine", SHARED / "machine.toml", "--model", "m.json", "--at", "p.csv"]
    if "-o" not in options:
        options = (*options, "-o", "d.csv")
    run = subprocess.run([*map(str, command), *options], cwd=folder, capture_output=True, text=True, timeout=60)
    assert run.returncode == status, (run.returncode, run.stderr)
    return run


def rows(folder):
    return list(csv.DictReader((folder / "d.csv").read_text().splitlines()))


def with_backlash(std=None):
    model = json.loads((SHARED / "model.json").read_text())
    entry = {"value": 10, "unit": "urad"}
    if std is not None:
        entry["std"] = std
    model["effects"] = [model["effects"][0], {"id": "backlash:C", "origin": "machine", "parameters": {"reversal": entry}}]
    return model


def passes_columns_through_and_appends_its_own(folder):
    evaluate(folder, HEADER + ",note\n# told by hand\n-30,60,10,20,30, as is \n")
    text = (folder / "d.csv").read_text().splitlines()
    assert text[0] == HEADER + ",note," + ",".join(RESULTS), text[0]
    assert text[1].startswith("-30,60,10,20,30, as is ,"), text[1]


def is_zero_at_the_reference_pose_and_the_same_a_turn_later(folder):
    evaluate(folder, HEADER + "\n0,0,10,20,30\n0,360,10,20,30\n-30,50,1,2,3\n-30,410,1,2,3\n")
    reference, turned, here, later = ([float(r[k]) for k in RESULTS] for r in rows(folder))
    assert max(map(abs, reference + turned)) < 1e-9, (reference, turned)
    assert all(abs(a - b) < 1e-9 for a, b in zip(here, later))


def moves_a_point_by_its_pose_error(folder):
    evaluate(folder, HEADER + "\n-30,60,0,0,0\n-30,60,100,0,0\n")
    origin, out = ({k: float(r[k]) for k in RESULTS} for r in rows(folder))
    for a, b in (("dx_um", "Dx_um"), ("dy_um", "Dy_um"), ("dz_um", "Dz_um")):
        assert abs(origin[a] - origin[b]) < 1e-9
    lever_m = 0.1
    assert abs(out["dy_um"] - origin["dy_um"] - lever_m * out["Dc_urad"]) < 1e-4
    assert abs(out["dz_um"] - origin["dz_um"] + lever_m * out["Db_urad"]) < 1e-4


def holds_the_end_only_when_told_to_and_flags_it(folder):
    assert evaluate(folder, HEADER + "\n-61,0,1,2,3\n", status=1).returncode == 1
    assert not (folder / "d.csv").exists()
    run = evaluate(folder, HEADER + "\n-61,40,1,2,3\n-60,40,1,2,3\n", "--extrapolate", "hold")
    beyond, end = rows(folder)
    assert beyond["extrapolated"] == "1" and end["extrapolated"] == "0"
    assert all(beyond[k] == end[k] for k in RESULTS)
    assert "1 rows" in run.stderr


def says_what_it_does_not_know(folder):
    run = evaluate(folder, HEADER + "\n-30,60,10,20,30\n", model=with_backlash())
    assert "C_dir" in run.stderr, run.stderr
    plain = rows(folder)[0]
    evaluate(folder, HEADER + ",C_dir\n-30,60,10,20,30,1\n-30,60,10,20,30,-1\n", model=with_backlash())
    forth, back = rows(folder)
    assert all(plain[k] == forth[k] for k in RESULTS)
    # The table stands 10 urad further about C: about R's axes at A -30 that is (0, sin 30, cos 30).
    assert abs(float(back["Db_urad"]) - float(forth["Db_urad"]) - 10 * math.sin(math.radians(30))) < 1e-6
    assert abs(float(back["Dc_urad"]) - float(forth["Dc_urad"]) - 10 * math.cos(math.radians(30))) < 1e-6


def holds_a_covariate_at_the_end_of_what_was_observed(folder):
    model = with_backlash()
    model["fit"] = {"observed": {"C_dir": [1, 1]}}
    run = evaluate(folder, HEADER + ",C_dir\n-30,60,10,20,30,-1\n-30,60,10,20,30,1\n", model=model)
    beyond, end = rows(folder)
    assert "held at the end" in run.stderr and all(beyond[k] == end[k] for k in RESULTS)


def has_uncertainties_only_where_the_model_has_them(folder):
    evaluate(folder, HEADER + "\n-30,60,10,20,30\n")
    assert "sd_um" not in rows(folder)[0]
    model = json.loads((SHARED / "model.json").read_text())
    values = model["effects"][0]["values"]
    ones = {k: {"unit": v["unit"], "data": [1] * 3 if k.endswith("A") else [[1] * 3] * 3} for k, v in values.items()}
    model["effects"][0]["std"] = ones
    evaluate(folder, HEADER + "\n-30,60,10,20,30\n", model=model)
    row = {k: float(v) for k, v in rows(folder)[0].items()}
    assert row["sd_um"] > 1
    assert abs(row["sd_um"] - math.hypot(row["sdx_um"], row["sdy_um"], row["sdz_um"])) < 1e-9


def writes_to_standard_output_for_a_dash(folder):
    run = evaluate(folder, HEADER + "\n-30,60,10,20,30\n", "-o", "-", "--quiet")
    assert run.stdout.startswith(HEADER) and len(run.stdout.splitlines()) == 2 and run.stderr == ""


def summarises_in_json(folder):
    run = evaluate(folder, HEADER + "\n-30,60,10,20,30\n", "--json", "--quiet", model=with_backlash())
    summary = json.loads(run.stdout)
    assert summary["rows"] == 1 and summary["at_zero_for_want_of"] == ["C_dir"], summary


def main():
    laws = [f for name, f in globals().items() if callable(f) and getattr(f, "__code__", None)
            and f.__code__.co_varnames[:1] == ("folder",) and name not in ("evaluate", "rows")]
    for law in laws:
        with tempfile.TemporaryDirectory() as name:
            law(pathlib.Path(name))
        print("evaluate", law.__name__.replace("_", " "))
    return 0 if laws else 1


if __name__ == "__main__":
    sys.exit(main())
