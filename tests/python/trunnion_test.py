"""The Python module against the program, known truths and its own stub.

    TRUNNION=PROGRAM TRUNNION_SOURCE=SOURCE_DIR PYTHONPATH=BUILD/python python3 -m pytest trunnion_test.py
"""
import ast
import csv
import json
import locale
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import trunnion

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from comma_locale import NAME as COMMA, comma_locale  # noqa: E402

PROGRAM = os.environ["TRUNNION"]
SOURCE = pathlib.Path(os.environ["TRUNNION_SOURCE"])
SAMPLE = SOURCE / "samples" / "calibrate"


@pytest.fixture(scope="module")
def machine():
    return trunnion.Machine(SAMPLE / "machine.toml")


@pytest.fixture(scope="module")
def observations(machine):
    return trunnion.Observations(SAMPLE / "replica.csv", machine)


@pytest.fixture(scope="module")
def found(machine, observations):
    return trunnion.identify(machine, observations)


@pytest.fixture(scope="module")
def truth():
    with open(SAMPLE / "truth.csv", encoding="utf-8") as file:
        rows = [line for line in file if not line.startswith("#")]
    return {name: np.array(column, dtype=float) for name, column in
            zip(rows[0].strip().split(","), zip(*csv.reader(rows[1:])))}


def program(*words, folder):
    return subprocess.run([PROGRAM, *map(str, words)], cwd=folder, check=True, capture_output=True, timeout=120)


def model_by_program(folder):
    program("identify", "--machine", SAMPLE / "machine.toml", "--observations", SAMPLE / "replica.csv", "-o",
            "model.json", folder=folder)
    return folder / "model.json"


def test_identify_finds_the_known_errors_within_their_uncertainty(found, truth):
    a, c = found.model.tilt_deg, found.model.turn_deg
    for symbol in ("EXA", "EYA", "EZA", "EAA", "EBA", "ECA", "EXC", "EYC", "EZC", "EAC", "EBC", "ECC"):
        unit = "um" if symbol[1] in "XYZ" else "urad"
        of_node = {(x, y): v for x, y, v in zip(truth["A_deg"], truth["C_deg"], truth[f"{symbol}_{unit}"])}
        error, std = found.model.error(symbol), found.model.std(symbol)
        if symbol[2] == "C":
            wanted = np.array([[of_node[x, y] for y in c] for x in a])
        else:
            wanted = np.array([of_node[x, c[0]] for x in a])
        assert error.shape == wanted.shape == std.shape
        assert np.all(np.abs(error - wanted) < 4.5 * std + 1e-3), symbol


def test_identify_and_the_program_write_the_same_map(found, tmp_path):
    by_program = json.loads(model_by_program(tmp_path).read_text())
    assert json.loads(found.model.text)["effects"] == by_program["effects"]
    assert found.summary["sigma_found_um"] == by_program["fit"]["sigma_found_um"]


def test_evaluate_agrees_with_the_program_row_by_row(machine, tmp_path):
    model_file = model_by_program(tmp_path)
    program("evaluate", "--machine", SAMPLE / "machine.toml", "--model", model_file, "--at", SAMPLE / "positions.csv",
            "-o", "out.csv", folder=tmp_path)
    with open(tmp_path / "out.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))

    def columns(*names):
        return np.array([[float(row[name]) for name in names] for row in rows])
    result = trunnion.evaluate(machine, trunnion.Model(model_file, machine), columns("A_deg")[:, 0],
                               columns("C_deg")[:, 0], columns("x_mm", "y_mm", "z_mm"))
    assert np.array_equal(result.deviation_um, columns("dx_um", "dy_um", "dz_um"))
    assert np.array_equal(result.table_error, columns("Dx_um", "Dy_um", "Dz_um", "Da_urad", "Db_urad", "Dc_urad"))
    assert np.array_equal(result.sd_um, columns("sdx_um", "sdy_um", "sdz_um"))


def test_evaluate_reads_strided_arrays_and_broadcasts(machine, found):
    angles = np.linspace(0, 300, 14)
    strided = np.zeros((14, 2))
    strided[:, 0] = angles
    whole = trunnion.evaluate(machine, found.model, -30, angles, [100, 0, 50])
    sliced = trunnion.evaluate(machine, found.model, np.full(14, -30.0), strided[:, 0], np.tile([100, 0, 50], (14, 1)))
    backwards = trunnion.evaluate(machine, found.model, -30, angles[::-1], [100, 0, 50])
    assert np.array_equal(whole.deviation_um, sliced.deviation_um)
    assert np.array_equal(whole.deviation_um, backwards.deviation_um[::-1])


def test_evaluate_refuses_what_was_not_probed(machine, found):
    with pytest.raises(trunnion.RangeError, match=r"A_deg\[1\]"):
        trunnion.evaluate(machine, found.model, [0, 5], 0, [0, 0, 0])
    held = trunnion.evaluate(machine, found.model, [0, 5], 0, [0, 0, 0], hold=True)
    assert list(held.extrapolated) == [False, True]
    assert np.array_equal(held.deviation_um[0], held.deviation_um[1])


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_evaluate_refuses_numbers_that_are_none(machine, found, bad):
    for arguments in ([bad, 0, [0, 0, 0]], [0, bad, [0, 0, 0]], [0, 0, [0, bad, 0]]):
        with pytest.raises(trunnion.UsageError):
            trunnion.evaluate(machine, found.model, *arguments)


def test_evaluate_refuses_lengths_that_do_not_match(machine, found):
    for arguments in ([[0, 0], [0, 0, 0], [0, 0, 0]], [0, 0, [0, 0]], [[0, 0, 0], 0, np.zeros((2, 3))],
                      [np.zeros((2, 2)), 0, [0, 0, 0]]):
        with pytest.raises(trunnion.UsageError):
            trunnion.evaluate(machine, found.model, *arguments)


def test_observations_are_views_that_outlive_their_owner(machine):
    observations = trunnion.Observations(SAMPLE / "replica.csv", machine)
    position = observations.position_mm
    assert position.base is observations and not position.flags.writeable
    assert np.shares_memory(position, observations.position_mm)
    first = position[0].copy()
    del observations
    assert np.array_equal(position[0], first)
    with open(SAMPLE / "replica.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert np.array_equal(position, [[float(row[k]) for k in ("x_mm", "y_mm", "z_mm")] for row in rows])


def test_close_finds_nothing_where_nothing_is_missing(machine, observations):
    closure = trunnion.close(machine, observations)
    assert closure.verdict == "nothing missing" == closure.summary["verdict"]
    residual = closure.residual_after
    assert residual.base is closure and len(residual) >= 200
    assert 1e3 * np.sqrt(np.mean(residual**2)) == pytest.approx(closure.summary["after"]["rms_um"], rel=0.02)


def test_close_names_the_cause_on_a_probing_sample():
    folder = SOURCE / "samples" / "probing" / "machine-01"
    machine = trunnion.Machine(folder / "machine.toml")
    calibration = trunnion.Observations(folder / "observations.csv", machine)
    verification = trunnion.Observations(folder / "verification.csv", machine)
    closure = trunnion.close(machine, calibration, verification)
    assert len(closure.residual_before) == len(calibration) + len(verification)
    assert closure.summary["after"]["reduced_chi2"] <= closure.summary["before"]["reduced_chi2"]


PROBING = SOURCE / "samples" / "probing" / "machine-01"


def closed_by_program(folder, *words):
    program("close", "--machine", PROBING / "machine.toml", *words, "-o", "closed", folder=folder)
    return json.loads((folder / "closed" / "closure.json").read_text())


def test_close_takes_the_active_compensation_out_as_the_program_does(machine, tmp_path):
    machine = trunnion.Machine(PROBING / "machine.toml")
    calibration = trunnion.Observations(PROBING / "observations.csv", machine)
    verification = trunnion.Observations(PROBING / "verification.csv", machine)
    found = json.loads(trunnion.identify(machine, calibration).model.text)
    # Little of it, as if the rest were compensated elsewhere.
    rotary = found["effects"][0]
    for error in rotary["values"].values():
        error["data"] = (0.2 * np.array(error["data"])).tolist()
    rotary["interpolation"]["coefficients"] = (0.2 * np.array(rotary["interpolation"]["coefficients"])).tolist()
    model = trunnion.Model.parse(json.dumps(found), machine)
    model.save(tmp_path / "active.json")
    by_program = closed_by_program(tmp_path, "--observations", PROBING / "observations.csv", "--verification",
                                   PROBING / "verification.csv", "--active", "active.json", "--active-only", "verification")
    closures = [trunnion.close(machine, calibration, verification, active=active, active_only="verification")
                for active in (model, tmp_path / "active.json")]
    without = trunnion.close(machine, calibration, verification)
    for closure in closures:
        assert closure.summary["before"] == pytest.approx(by_program["before"], abs=1e-9)
        assert [e["id"] for e in closure.summary["effects"]] == [e["id"] for e in by_program["effects"]]
        assert abs(closure.summary["before"]["rms_um"] - without.summary["before"]["rms_um"]) > 0.01  # um


def test_identify_takes_the_active_tables_out(machine, observations, found, tmp_path):
    tables = trunnion.tables(machine, found.model, "linuxcnc")
    tables.write(tmp_path / "tables")
    by_value = trunnion.identify(machine, observations, active=tables)
    by_folder = trunnion.identify(machine, observations, active=tmp_path / "tables")
    assert np.array_equal(by_value.model.error("EXC"), by_folder.model.error("EXC"))
    # The bare machine then has what was seen and what the tables took out of it: about twice.
    assert by_value.model.error("EAA")[0] == pytest.approx(2 * found.model.error("EAA")[0], rel=0.02)
    other = trunnion.Machine.parse((SAMPLE / "machine.toml").read_text().replace('serial = "0001"', 'serial = "0002"'))
    for active in (tables, tmp_path / "tables", found.model):
        with pytest.raises(trunnion.RefusalError, match="0001.*0002"):
            trunnion.identify(other, observations, active=active)


def test_close_takes_a_measured_piece_as_the_program_does(machine, observations, found, tmp_path):
    piece = trunnion.Piece(SOURCE / "samples" / "predict" / "piece.toml")
    prediction = trunnion.predict(machine, found.model, piece)
    rows = ["phi_deg,h_mm,deviation_um"]
    noise = np.random.default_rng(5).normal(0, 0.2, prediction.deviation_um["uncompensated"].shape)
    for h, measured in zip(prediction.h_mm, prediction.deviation_um["uncompensated"] + noise):
        rows += [f"{phi},{h},{d:.4f}" for phi, d in zip(prediction.phi_deg[::10], measured[::10])]
    (tmp_path / "measured.csv").write_text("\n".join(rows) + "\n")
    program("close", "--machine", SAMPLE / "machine.toml", "--observations", SAMPLE / "replica.csv", "--piece",
            SOURCE / "samples" / "predict" / "piece.toml", "--measured", "measured.csv", "-o", "closed", folder=tmp_path)
    by_program = json.loads((tmp_path / "closed" / "closure.json").read_text())
    closure = trunnion.close(machine, observations, piece=piece, measured=tmp_path / "measured.csv")
    assert closure.verdict == by_program["verdict"]
    assert closure.summary["piece"]["before"]["rms_um"] == pytest.approx(by_program["piece"]["before"]["rms_um"], abs=1e-6)
    assert len(closure.residual_before) > len(observations)
    for bad in ({"piece": piece}, {"measured": tmp_path / "measured.csv"}, {"program": "G1 X1"}):
        with pytest.raises(trunnion.UsageError, match="piece, measured"):
            trunnion.close(machine, observations, **bad)
    with pytest.raises(trunnion.UsageError, match="observations"):
        trunnion.close(machine)


def test_numbers_do_not_depend_on_the_locale_of_the_host(machine, observations, found, tmp_path, monkeypatch):
    """The program that loads the module may have set a locale with a decimal comma."""
    environment = comma_locale(tmp_path)
    if environment is None:
        pytest.skip("no locale with a decimal comma can be made")
    monkeypatch.setenv("LOCPATH", environment["LOCPATH"])
    wanted = trunnion.tables(machine, found.model, "linuxcnc").files
    try:
        locale.setlocale(locale.LC_ALL, COMMA)
        assert locale.localeconv()["decimal_point"] == ","
        there = trunnion.Machine(SAMPLE / "machine.toml")
        again = trunnion.identify(there, trunnion.Observations(SAMPLE / "replica.csv", there))
        assert again.model.text == found.model.text
        assert trunnion.tables(there, again.model, "linuxcnc").files == wanted
        part = (SOURCE / "samples" / "correct" / "part.ngc").read_bytes()
        corrected = trunnion.correct(there, again.model, part, trunnion.Job(SOURCE / "samples" / "correct" / "job.toml"))
    finally:
        locale.setlocale(locale.LC_ALL, "C")
    assert corrected.program == trunnion.correct(
        machine, found.model, part, trunnion.Job(SOURCE / "samples" / "correct" / "job.toml")).program


def test_correct_writes_what_the_program_writes(machine, tmp_path):
    sample = SOURCE / "samples" / "correct"
    model_file = model_by_program(tmp_path)
    program("correct", "--machine", SAMPLE / "machine.toml", "--model", model_file, "--job", sample / "job.toml",
            sample / "part.ngc", "-o", "out.ngc", "--report", "r.json", folder=tmp_path)
    corrected = trunnion.correct(machine, trunnion.Model(model_file, machine), (sample / "part.ngc").read_bytes(),
                                 trunnion.Job(sample / "job.toml"))
    # The header comment tells the hash of the model's file, and lists are written with the file's own blanks.
    without_header = [line for line in corrected.program.splitlines() if b"corrected by trunnion" not in line]
    expected = [line for line in (tmp_path / "out.ngc").read_bytes().splitlines()
                if b"corrected by trunnion" not in line]
    assert without_header == expected
    report = json.loads((tmp_path / "r.json").read_text())
    assert corrected.report["playback"]["after"] == report["playback"]["after"]
    assert corrected.report["playback"]["before"]["position_rms_um"] > 1


def test_correct_refuses_a_program_beyond_what_was_probed(machine, found):
    with pytest.raises(trunnion.RangeError, match="program:2:"):
        trunnion.correct(machine, found.model, "G21 G90 G54\nG1 F500 X0 Y0 Z0 A10 C0\nM2\n")


def test_tables_are_those_of_the_program(machine, tmp_path):
    model_file = model_by_program(tmp_path)
    tables = trunnion.tables(machine, trunnion.Model(model_file, machine), "linuxcnc")
    program("tables", "--machine", SAMPLE / "machine.toml", "--model", model_file, "--controller", "linuxcnc", "-o",
            "by_program", folder=tmp_path)
    tables.write(tmp_path / "by_module")
    for name, text in tables.files.items():
        assert (tmp_path / "by_module" / name).read_text() == text
        if name != "verification.json":  # the program adds the hashes of its files
            assert (tmp_path / "by_program" / name).read_text() == text, name
    assert tables.load_ready and tables.verification["position_rms_um"]["tables"] < 0.5


def test_predict_agrees_with_the_program(machine, tmp_path):
    model_file, piece_file = model_by_program(tmp_path), SOURCE / "samples" / "predict" / "piece.toml"
    prediction = trunnion.predict(machine, trunnion.Model(model_file, machine), trunnion.Piece(piece_file),
                                  corrected=True, draws=50, seed=3)
    program("predict", "--machine", SAMPLE / "machine.toml", "--model", model_file, "--piece", piece_file,
            "--corrected", "--draws", "50", "--seed", "3", "-o", "piece", folder=tmp_path)
    by_program = json.loads((tmp_path / "piece" / "prediction.json").read_text())
    heights, points = len(prediction.h_mm), len(prediction.phi_deg)
    for name in ("uncompensated", "corrected"):
        assert prediction.deviation_um[name].shape == (heights, points)
        # The program takes the solid's own rulings where it has a modeller, the module the formula's.
        assert prediction.summary[name]["rms_um"] == pytest.approx(by_program[name]["rms_um"], abs=1e-6)
        for mine, theirs in zip(prediction.summary[name]["heights"], by_program[name]["heights"]):
            assert mine["lsc_um"] == pytest.approx(theirs["lsc_um"], abs=1e-6)
            assert mine["lsc_um_sd"] == pytest.approx(theirs["lsc_um_sd"], abs=1e-6)


def test_a_model_of_another_machine_is_refused(machine, found):
    other = trunnion.Machine.parse((SAMPLE / "machine.toml").read_text().replace('serial = "0001"', 'serial = "0002"'))
    assert other.serial == "0002"
    with pytest.raises(trunnion.RefusalError, match="0002"):
        trunnion.Model.parse(found.model.text, other)
    with pytest.raises(trunnion.RefusalError):
        trunnion.tables(other, found.model, "linuxcnc")


def test_errors_are_one_line_and_of_one_family(tmp_path):
    with pytest.raises(trunnion.InputError, match="machine.toml:1"):
        trunnion.Machine.parse("format = 3\n")
    with pytest.raises(trunnion.Error) as caught:
        trunnion.Machine(tmp_path / "missing.toml")
    assert "missing.toml" in str(caught.value) and "\n" not in str(caught.value)


def test_a_prior_is_believed_as_far_as_the_drift_allows(machine, observations, found):
    with pytest.raises(trunnion.UsageError, match="drift"):
        trunnion.identify(machine, observations, prior=found.model)
    believed = trunnion.identify(machine, observations, prior=found.model, drift_um=0.01, drift_urad=0.01)
    assert np.all(believed.model.std("EXC") < found.model.std("EXC"))


def stub_names():
    """{class or None: names} that the stub tells of."""
    names = {None: set()}
    for node in ast.parse((pathlib.Path(trunnion.__file__).parent / "__init__.pyi").read_text()).body:
        if isinstance(node, ast.ClassDef):
            names[None].add(node.name)
            names[node.name] = {n.name for n in node.body if isinstance(n, ast.FunctionDef) and n.name[0] != "_"}
        elif isinstance(node, ast.FunctionDef):
            names[None].add(node.name)
    return names


def test_the_stub_names_what_there_is_and_nothing_else():
    stub = stub_names()
    assert stub.pop(None) | {"__version__"} == set(trunnion.__all__)
    for name, members in stub.items():
        there = getattr(trunnion, name)
        if not issubclass(there, Exception):
            assert members == {member for member in vars(there) if member[0] != "_"}, name


def test_the_stub_has_the_signatures_of_the_functions():
    tree = ast.parse((pathlib.Path(trunnion.__file__).parent / "__init__.pyi").read_text())
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            arguments = [a.arg for a in node.args.args + node.args.kwonlyargs]
            told = getattr(trunnion, node.name).__doc__.splitlines()[0]
            positions = [told.find(f"{a}: ") for a in arguments]
            assert min(positions) > 0 and positions == sorted(positions), told


def test_every_name_is_documented():
    for name in trunnion.__all__:
        if name != "__version__":
            assert getattr(trunnion, name).__doc__, name


def test_the_figures_are_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    figures = SOURCE / "samples" / "python" / "figures.py"
    subprocess.run([sys.executable, figures, tmp_path], check=True, timeout=120,
                   env={**os.environ, "MPLBACKEND": "Agg", "MPLCONFIGDIR": str(tmp_path)})
    for name in ("figure_6.png", "figure_7.png", "figure_8.png"):
        assert (tmp_path / name).read_bytes()[:4] == b"\x89PNG"
