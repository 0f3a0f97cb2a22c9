#!/usr/bin/env python3
"""What `tables` refuses of a machine file and what it then says, word for word, for every controller.

    tables_refusals_test.py PROGRAM SOURCE_DIR OUTPUT_DIR

A row: controller, what is changed in the machine of samples/tables/small, options, exit status, message. Nothing may be written, nor
left of a set that stood there. Status 2 is a file that contradicts itself, 1 a limit that protects the machine.
"""
import pathlib
import re
import shutil
import subprocess
import sys

CONTROLLERS = ["linuxcnc", "sinumerik-840d", "isg-twincat", "heidenhain", "fanuc-30i", "aerotech"]
CONFIRMED = "is wanted, followed by \" confirmed\" once it was seen on the machine"

# What all controllers refuse alike.
COMMON = [
    ("table_slope = \"steep\"", [], 2, "profile.table_slope: \"steep\" found, a number from 1e-06 to 1 is wanted"),
    ("table_slope = 0", [], 2, "profile.table_slope: 0 found, a number from 1e-06 to 1 is wanted"),
    ("table_slop = 0.016", [], 2, "profile.table_slop: not known; the nearest that {controller} asks for is \"table_slope\""),
    ("correction_um = 1", [], 1,
     "the deviation that the tables correct at A -43.108 C 272.936 deg is {corrected} um, limits.correction_um allows 1"),
    ("A_deg = [-91, 0]", [], 1, "work_volume.A_deg: -91 to 0 asked for, the model was probed from -90 to 0"),
    ("", ["--spacing", "0.05"], 2, "--spacing: 0.1 to 90 deg is wanted"),
    ("", ["--tool-length", "1e9"], 2, "--tool-length: a length in mm is wanted"),
]

# What each corrects at the first pose that is looked at, nodes 30 deg apart, um.
CORRECTED = {"linuxcnc": "2.463", "sinumerik-840d": "2.466", "isg-twincat": "2.452", "heidenhain": "2.464", "fanuc-30i": "2.597",
             "aerotech": "2.465"}

# Signs, orders and rules that have answers: one that is none of them.
ANSWERS = {
    "sinumerik-840d": {
        "cec_sign": ["add", "subtract"],
        "cec_product": ["instead of the table's own value", "beside the table's own value"],
        "cec_factor": ["works while switched off", "must be switched on"],
        "trafo5_axes": ["against the axis", "along the axis", "not to be set"],
        "trafo5_joint": ["JOINT_OFFSET_PART", "JOINT_OFFSET"],
    },
    "isg-twincat": {
        "volc_sense": ["values are errors", "values are added to the command"],
        "volc_reference": ["yes"],
    },
    "heidenhain": {
        "com_sign": ["error", "correction"],
        "comptab_prefix": ["axis letter", "A"],
        "com_angles": ["degrees, linear"],
        "com_layout": ["yes"],
        "com_backlash": ["value in negative travel", "difference to positive travel"],
    },
    "fanuc-30i": {
        "pitch_sign": ["add", "subtract"],
        "pitch_interpolation": ["even"],
        "pitch_blocks": ["N10000 + point"],
        "tcp_vectors": ["yes"],
        "pitch_reverse": ["upwards"],
        "pitch_reference": ["in units of 3623", "in detection units"],
    },
    "aerotech": {
        "cal_sign": ["add", "subtract"],
        "encoder_senses": ["yes"],
    },
}

# Numbers of a profile: key, what is wanted, values that are not.
NUMBERS = {
    "sinumerik-840d": [
        ("cec_tables", "a whole number from 1 to 200", [0, 201, 7.5, "\"many\"", "true"]),
        ("cec_points", "a whole number from 3 to 5000", [2, 100.5]),
        ("eec_points", "a whole number from 3 to 5000", [2]),
        ("trafo5_number", "a whole number from 1 to 20", [0, 1.5]),
        ("axis_number_X", "a whole number from 1 to 31", [0, 32, 1.5]),
    ],
    "isg-twincat": [
        ("volc_max_records", "a whole number from 10 to 1e+06", [9, 10.5]),
        ("axis_number_A", "a whole number from 1 to 64", [65, -1]),
    ],
    "heidenhain": [
        ("com_decimals", "a whole number from 3 to 7", [2, 8, 4.5]),
        ("comptab_entries", "a whole number from 1 to 95", [0, 96]),
    ],
    "fanuc-30i": [
        ("detection_unit_deg", "a number from 1e-06 to 0.01", [0, 0.1]),
        ("axis_number_C", "a whole number from 1 to 32", [33]),
    ],
    "aerotech": [
        ("cal_tables", "a whole number from 1 to 100", [0, 101]),
        ("encoder_sense_X", "-1 or 1", [0, 2, 0.5]),
        ("axis_number_Y", "a whole number from 1 to 64", [0]),
    ],
}

# A key spelt wrong, and what it should have been.
MISSPELT = {"linuxcnc": ("table_slopes", "table_slope"), "sinumerik-840d": ("cec_sing", "cec_sign"),
            "isg-twincat": ("volc_sens", "volc_sense"), "heidenhain": ("com_singe", "com_sign"),
            "fanuc-30i": ("pitch_sine", "pitch_sign"), "aerotech": ("cal_sing", "cal_sign")}

# Limits of each control and of its tables.
LIMITS = [
    ("linuxcnc", "table_slope = 0.00001", [], 1, "joint_C.comp: changes by 1.1e-05 deg per deg behind -350, profile.table_slope allows 1e-05"),
    ("sinumerik-840d", "table_slope = 0.00001", ["--spacing", "30"], 1,
     "the tables' Y changes by 8.453e-05 mm per deg of A at A -43.108 C 272.936 deg, profile.table_slope allows 1e-05"),
    ("isg-twincat", "table_slope = 0.00001", ["--spacing", "30"], 1,
     "the tables' Y changes by 7.436e-05 mm per deg of A at A -43.108 C 272.936 deg, profile.table_slope allows 1e-05"),
    ("heidenhain", "table_slope = 0.00001", ["--spacing", "30"], 1,
     "the tables' Y changes by 8.395e-05 mm per deg of A at A -43.108 C 272.936 deg, profile.table_slope allows 1e-05"),
    ("fanuc-30i", "table_slope = 0.00001", ["--spacing", "30"], 1,
     "the tables' Y changes by 5.248e-05 mm per deg of A at A -43.108 C 272.936 deg, profile.table_slope allows 1e-05"),
    ("aerotech", "table_slope = 0.00001", ["--spacing", "30"], 1,
     "the tables' Y changes by 8.217e-05 mm per deg of A at A -43.108 C 272.936 deg, profile.table_slope allows 1e-05"),
    ("sinumerik-840d", "cec_points = 10", ["--spacing", "30"], 1,
     "sinumerik-840d: tables of 13 nodes, profile.cec_points allows 10 and profile.eec_points 400"),
    ("sinumerik-840d", "eec_points = 12", ["--spacing", "30"], 1,
     "sinumerik-840d: tables of 13 nodes, profile.cec_points allows 400 and profile.eec_points 12"),
    ("isg-twincat", "volc_max_records = 20", ["--spacing", "30"], 1,
     "isg-twincat: 56 records, vol_comp.max_records (profile.volc_max_records) allows 20"),
    ("heidenhain", "", ["--spacing", "1"], 1, "heidenhain: 361 entries, 256 is the most of a .COM table"),
    ("fanuc-30i", "", ["--spacing", "2"], 1, "fanuc-30i: 181 points on one axis, 128 is the most"),
    ("fanuc-30i", "A_deg = [-90, -30]", ["--spacing", "30"], 1,
     "fanuc-30i: the working volume does not reach the reference position of the tilting axis, from which pitch errors are counted"),
    ("aerotech", "cal_tables = 1", ["--spacing", "30"], 1, "aerotech: 2 tables, profile.cal_tables allows 1"),
]


def machine_text(source, change):
    """The machine of the sample: a line whose key stands there takes its place, another goes into [profile]."""
    text = (source / "samples/tables/small/machine.toml").read_text().replace("cec_tables = 8\n", "")
    if not change:
        return text
    key = change.split(" = ")[0]
    line = re.compile(rf"^{re.escape(key)} = .*$", re.M)
    return line.sub(change, text) if line.search(text) else text + change + "\n"


def rows():
    for controller in CONTROLLERS:
        for change, options, status, message in COMMON:
            yield controller, change, options, status, message.replace("{controller}", controller).replace("{corrected}", CORRECTED[controller])
        wrong, right = MISSPELT[controller]
        yield controller, f"{wrong} = \"confirmed\"", [], 2, (
            f"profile.{wrong}: not known; the nearest that {controller} asks for is \"{right}\"")
        for key, answers in ANSWERS.get(controller, {}).items():
            wanted = ", ".join(f"\"{answer}\"" for answer in answers)
            for found in ["\"no such\"", "\"no such confirmed\"", f"\"{answers[0]} confirmd\"", "true", "1"]:
                yield controller, f"{key} = {found}", [], 2, f"profile.{key}: {found} found, one of {wanted} {CONFIRMED}"
        for key, wanted, values in NUMBERS.get(controller, []):
            for value in values:
                yield controller, f"{key} = {value}", [], 2, f"profile.{key}: {value} found, {wanted} is wanted"
        if controller not in ("linuxcnc", "heidenhain"):  # these know axes by their letters
            yield controller, "axis_number_Z = 2", [], 2, "profile.axis_number_Z: 2 is Y's number, another is wanted"
    yield from LIMITS


def check(program, source, out, row):
    controller, change, options, status, message = row
    machine = out / "machine.toml"
    machine.write_text(machine_text(source, change))
    folder = out / "tables"
    command = [program, "tables", "--machine", machine, "--model", source / "samples/tables/small/model.json", "--controller",
               controller, *options, "-o", folder, "--quiet"]
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=120)
    if folder.exists() and any(folder.iterdir()):
        left = sorted(p.name for p in folder.iterdir())
        shutil.rmtree(folder)
        return f"wrote {left}, status {result.returncode}"
    if result.returncode != status or result.stdout or result.stderr != f"trunnion: {message}\n":
        return f"status {result.returncode}, {status} is wanted; said\n  {result.stderr.strip()}\nwanted\n  trunnion: {message}"
    return None


def main():
    program, source, out = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    failures = 0
    for row in rows():
        finding = check(program, source, out, row)
        if finding:
            print(f"{row[0]}, {row[1]!r} {row[2]}: {finding}", file=sys.stderr)
            failures += 1
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
