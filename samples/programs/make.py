#!/usr/bin/env python3
"""Writes the programs of this folder: four parts in four dialects.

    make.py [FOLDER]

X Y Z are places of the tool's tip on the part (tool-centre-point control), A <= 0 and C those of a trunnion whose table
turns right-handed: the tool's axis on the part is (sin C sin A, cos C sin A, cos A).
"""
import math
import pathlib
import sys

END = {"linuxcnc": "ngc", "fanuc": "nc", "sinumerik": "mpf", "heidenhain": "h"}


class Writer:
    """The words of one dialect."""

    def __init__(self, dialect, name):
        self.dialect, self.lines = dialect, []
        put = self.lines.append
        if dialect == "linuxcnc":
            self.lines += ["%", f"({name})", "G21 G90 G94 G17 G40 G49", "G54", "T1 M6", "S9000 M3"]
        elif dialect == "fanuc":
            self.lines += ["%", f"O1001 ({name})", "G21 G90 G94 G17 G40 G49 G80", "G54", "T1 M6", "S9000 M3"]
        elif dialect == "sinumerik":
            self.lines += [f"%_N_{name}_MPF", ";$PATH=/_N_WKS_DIR", "G710 G90 G94 G17 G40", f'MSG("{name}")', "G54",
                           'T="MILL10" D1', "M6", "S9000 M3"]
        else:
            put(f"BEGIN PGM {name} MM")
            self.lines += ["BLK FORM 0.1 Z X-60 Y-60 Z-10", "BLK FORM 0.2 X+60 Y+60 Z+80", "TOOL CALL 1 Z S9000", "M3"]
        self.name = name

    def move(self, x=None, y=None, z=None, a=None, c=None, f=None, rapid=False):
        places = [(l, v) for l, v in zip("XYZAC", (x, y, z, a, c)) if v is not None]
        if self.dialect == "heidenhain":
            words = [f"{l}{v:+.3f}" for l, v in places]
            self.lines.append(" ".join(["L"] + words + (["R0 FMAX"] if rapid else [f"F{f}"] if f else [])))
            return
        if self.dialect == "fanuc":
            words = [l + self.point(v) for l, v in places]
        elif self.dialect == "sinumerik":
            words = [(f"{l}={v:.3f}" if l in "AC" else f"{l}{v:.3f}") for l, v in places]
        else:
            words = [f"{l}{v:.3f}" for l, v in places]
        feed = [("F" + self.point(f)) if self.dialect == "fanuc" else f"F{f}"] if f else []
        self.lines.append(" ".join(["G0" if rapid else "G1"] + words + feed))

    @staticmethod
    def point(value):
        text = f"{value:.3f}".rstrip("0")
        return text if text != "-0." else "0."

    def tip_control(self, on):
        code = {"fanuc": ("G43.4 H1", "G49"), "sinumerik": ("TRAORI", "TRAFOOF"), "heidenhain": ("M128", "M129")}
        if self.dialect in code:
            self.lines.append(code[self.dialect][0 if on else 1])

    def end(self):
        tail = {"linuxcnc": ["M5", "M30", "%"], "fanuc": ["M5", "G91 G28 Z0.", "M30", "%"],
                "sinumerik": ["M5", "SUPA G0 Z0 D0", "M30"],
                "heidenhain": ["M5", "L Z-10 R0 FMAX M91", "M30", f"END PGM {self.name} MM"]}[self.dialect]
        lines = self.lines + tail
        if self.dialect == "heidenhain":
            lines = [f"{i} {line}" for i, line in enumerate(lines)]
        return "\n".join(lines) + "\n"


def five_axis(writer, points, feed):
    """Approach from above, then one line a point."""
    x, y, z, a, c = points[0]
    writer.move(a=a, c=c, rapid=True)
    writer.tip_control(True)
    writer.move(x, y, z + 40, a, c, rapid=True)
    writer.move(z=z, f=feed)
    for place in points[1:]:
        writer.move(*place)
    writer.move(z=points[-1][2] + 40, rapid=True)
    writer.tip_control(False)


def turbine_blade(w):
    """Two sections of a twisted blade, the tool leaning by 15 ... 35 deg, C going round without unwinding."""
    points = []
    for section in range(2):
        for i in range(41):
            t = 2 * math.pi * i / 40 + 0.4 * section
            twist = 0.3 * section
            x0, y0 = 28 * math.cos(t), 7 * math.sin(t)
            lean = 25 + 10 * math.sin(2 * t)
            points.append((x0 * math.cos(twist) - y0 * math.sin(twist), x0 * math.sin(twist) + y0 * math.cos(twist),
                           30 + 6 * section, -lean, math.degrees(t) + 360 * section))
    five_axis(w, points, 1800)


def impeller(w):
    """A channel between two blades: the tilt swings through 55 deg while C turns by 70."""
    points = []
    for pass_ in range(3):
        for i in range(26):
            s = i / 25 if pass_ % 2 == 0 else 1 - i / 25
            radius, angle = 15 + 30 * s, math.radians(20 + 50 * s + 4 * pass_)
            points.append((radius * math.cos(angle), radius * math.sin(angle), 45 - 25 * s ** 2 - pass_,
                           -8 - 55 * s, -30 + 70 * s))
    five_axis(w, points, 1200)


def cone_frustum(w):
    """The flank of a cone of 15 deg by the side of the cutter, a whole turn."""
    points = []
    for i in range(73):
        phi = math.radians(5 * i)
        points.append((45 * math.cos(phi), 45 * math.sin(phi), 20, -15, -90 - 5.0 * i))
    five_axis(w, points, 800)


def pocket(w):
    """A pocket in a face that is tilted by 40 deg: indexed, three axes cut."""
    corners = [(0, 0), (24, 0), (24, 16), (0, 16), (0, 0), (4, 4), (20, 4), (20, 12), (4, 12), (4, 4)]
    tilt, turn, origin = -40, 40, (12.0, -6.0, 35.0)
    if w.dialect == "linuxcnc":
        # The same places on the part, told in its own coordinates.
        a, c = math.radians(tilt), math.radians(turn)
        ex = (math.cos(c), -math.sin(c), 0)
        n = (math.sin(c) * math.sin(a), math.cos(c) * math.sin(a), math.cos(a))
        ey = (n[1] * ex[2] - n[2] * ex[1], n[2] * ex[0] - n[0] * ex[2], n[0] * ex[1] - n[1] * ex[0])
        on_part = lambda u, v, h: [origin[k] + u * ex[k] + v * ey[k] + h * n[k] for k in range(3)]
        w.move(*on_part(0, 0, 30), a=tilt, c=turn, rapid=True)
        w.move(*on_part(0, 0, -2), f=200)
        for u, v in corners[1:]:
            w.move(*on_part(u, v, -2), f=600)
        w.move(*on_part(0, 0, 30), rapid=True)
        return
    if w.dialect == "fanuc":
        w.lines += [f"G68.2 X{origin[0]:.1f} Y{origin[1]:.1f} Z{origin[2]:.1f} I{-turn:.1f} J{-tilt:.1f} K0.", "G53.1",
                    "G43 H1 Z60."]
    elif w.dialect == "sinumerik":
        w.lines.append(f'CYCLE800(1,"TC1",200000,39,{origin[0]},{origin[1]},{origin[2]},{-turn},{-tilt},0,0,0,0,-1,,1)')
    else:
        w.lines += ["CYCL DEF 7.0 DATUM SHIFT"] + [f"CYCL DEF 7.{k + 1} {'XYZ'[k]}{origin[k]:+.1f}" for k in range(3)]
        w.lines.append(f"PLANE SPATIAL SPA{-tilt:+.1f} SPB+0 SPC{-turn:+.1f} TURN FMAX SEQ- TABLE ROT")
    w.move(x=0, y=0, rapid=True)
    w.move(z=30, rapid=True)
    w.move(z=-2, f=200)
    for u, v in corners[1:]:
        w.move(x=u, y=v, f=600)
    if w.dialect == "heidenhain":
        w.lines += ["CC X+12 Y+8", "C X+4 Y+4 DR+"]
    else:
        i, j = ("I8. J4.", "") if w.dialect == "fanuc" else ("I8 J4", "")
        w.lines.append(("G3 " + i + j).strip())
    w.move(z=30, rapid=True)
    w.lines.append({"fanuc": "G69", "sinumerik": "CYCLE800()", "heidenhain": "PLANE RESET STAY"}[w.dialect])


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent)
    for part in (turbine_blade, impeller, cone_frustum, pocket):
        for dialect, end in END.items():
            writer = Writer(dialect, part.__name__.upper())
            part(writer)
            (folder / f"{part.__name__}.{end}").write_text(writer.end())


if __name__ == "__main__":
    main()
