#include <algorithm>
#include <cmath>

#include "compensation/controllers/linuxcnc.h"
#include "compensation/number_text.h"
#include "error.h"

namespace trunnion {
namespace {

// What comes before and after the data. The functions of the kinematics interface are documented in LinuxCNC's
// kinematics.h; pins are those of xyzac-trt-kins, so that its HAL files need a change of name only.
constexpr std::string_view kHead =
    R"comp(component trunnion_kins "Kinematics of a trunnion table with its measured errors";
description """
Tool-centre-point kinematics XYZAC of a tilting rotary table, like xyzac-trt-kins, for the machine as it was measured:
joints go where the real tool meets the real workpiece. All numbers are in this file; nothing is read at run time.

Pins: trunnion_kins.x-rot-point y-rot-point z-rot-point y-offset z-offset tool-offset, with the meaning they have in
xyzac-trt-kins; trunnion_kins.compensate (bit, in, at first true): false gives the nominal kinematics, to be changed with
the machine off; trunnion_kins.outside (bit, out): the tilt has left the measured range, the errors of its end are held.
motion.switchkins-type: 0 tool centre point, 1 identity.
""";
license "GPL";
author "trunnion";
option singleton yes;
option extra_setup yes;
pin out bit loaded = 1 "true once the component is there";
;;
#include <hal.h>
#include <kinematics.h>
#include <rtapi_math.h>

)comp";

constexpr std::string_view kBody = R"comp(
static char *coordinates = "XYZAC";
RTAPI_MP_STRING(coordinates, "Axis letters in order of joints; XYZAC");

static struct {
    hal_float_t *x_rot_point, *y_rot_point, *z_rot_point, *y_offset, *z_offset, *tool_offset;
    hal_bit_t *compensate, *outside;
} *pins;
static int switched_to; /* 0 tool centre point, 1 identity */

#define DEGREE 0.017453292519943295769
#define TURNS 0.017452406437283512820 /* sin 1 deg: how much C is held back where it can do little */

EXTRA_SETUP() {
    int bad = 0;
    (void)__comp_inst; (void)prefix; (void)extra_arg;
    if (are_not_xyzac(coordinates)) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trunnion_kins: coordinates=%s: XYZAC is wanted\n", coordinates);
        return -1;
    }
    pins = hal_malloc(sizeof *pins);
    if (!pins) return -1;
    bad |= hal_pin_float_newf(HAL_IN, &pins->x_rot_point, comp_id, "trunnion_kins.x-rot-point");
    bad |= hal_pin_float_newf(HAL_IN, &pins->y_rot_point, comp_id, "trunnion_kins.y-rot-point");
    bad |= hal_pin_float_newf(HAL_IN, &pins->z_rot_point, comp_id, "trunnion_kins.z-rot-point");
    bad |= hal_pin_float_newf(HAL_IN, &pins->y_offset, comp_id, "trunnion_kins.y-offset");
    bad |= hal_pin_float_newf(HAL_IN, &pins->z_offset, comp_id, "trunnion_kins.z-offset");
    bad |= hal_pin_float_newf(HAL_IN, &pins->tool_offset, comp_id, "trunnion_kins.tool-offset");
    bad |= hal_pin_bit_newf(HAL_IN, &pins->compensate, comp_id, "trunnion_kins.compensate");
    bad |= hal_pin_bit_newf(HAL_OUT, &pins->outside, comp_id, "trunnion_kins.outside");
    if (bad) return -1;
    *pins->x_rot_point = turn_axis[0];
    *pins->y_rot_point = turn_axis[1];
    *pins->z_rot_point = tilt_axis[1];
    *pins->y_offset = tilt_axis[0] - turn_axis[1];
    *pins->z_offset = 0;
    *pins->tool_offset = 0;
    *pins->compensate = 1;
    *pins->outside = 0;
    return 0;
}

/* The four cubic B-splines over a cell, u from 0 to 1 through it. */
static void splines(double u, double b[4]) {
    const double w = 1 - u;
    b[0] = w * w * w / 6;
    b[1] = (4 - 6 * u * u + 3 * u * u * u) / 6;
    b[2] = (4 - 6 * w * w + 3 * w * w * w) / 6;
    b[3] = u * u * u / 6;
}

/* Along a line of count - 3 cells: the first spline that matters and the place in its cell, ends held. */
static int cell_of(double x, double low, double step, int count, double *u) {
    double t = (x - low) / step;
    int cell;
    if (!(t > 0)) t = 0; /* also for what is no number */
    if (t > count - 3) t = count - 3;
    cell = (int)t;
    if (cell > count - 4) cell = count - 4;
    *u = t - cell;
    return cell;
}

/* The table's pose error (Dx Dy Dz Da Db Dc; mm, rad) at R's origin, plus what X, Y and Z add at the tip p of R. */
static void error_at(double tilt_deg, double turn_deg, const double p[3], double e[6]) {
    double u, v, bt[4], bc[4], t;
    int i, j, k, n, cell, first;
    for (k = 0; k < 6; ++k) e[k] = 0;
    cell = cell_of(tilt_deg, tilt_low, tilt_step, tilt_count, &u);
    splines(u, bt);
    t = turn_deg / 360;
    t = (t - floor(t)) * turn_count;
    first = (int)t;
    if (!(first >= 0 && first < turn_count)) first = 0, t = 0;
    v = t - first;
    splines(v, bc);
    for (i = 0; i < 4; ++i)
        for (j = 0; j < 4; ++j) {
            const double *c = error_map[cell + i][(first + j) % turn_count];
            for (k = 0; k < 6; ++k) e[k] += bt[i] * bc[j] * c[k];
        }
    for (n = 0; n < 3; ++n) {
        if (!linear_count[n]) continue;
        cell = cell_of(p[n], linear_low[n], linear_step[n], linear_count[n], &u);
        splines(u, bt);
        for (i = 0; i < 4; ++i) {
            const double *c = linear_splines + 9 * (linear_first[n] + cell + i);
            for (k = 0; k < 3; ++k) {
                e[k] += bt[i] * (c[k] + c[6 + k]); /* a deviation of the tip alone is a shift */
                e[3 + k] += bt[i] * c[3 + k];
            }
        }
    }
}

/* v turned by Rx(a), Ry(b), Rz(c), the last one first. */
static void turned(double a, double b, double c, double v[3]) {
    double s, t, x, y;
    s = sin(c), t = cos(c), x = v[0], y = v[1];
    v[0] = t * x - s * y, v[1] = s * x + t * y;
    s = sin(b), t = cos(b), x = v[0], y = v[2];
    v[0] = t * x + s * y, v[2] = t * y - s * x;
    s = sin(a), t = cos(a), x = v[1], y = v[2];
    v[1] = t * x - s * y, v[2] = s * x + t * y;
}

/* Nominal table: where the point w of the work frame stands with the axes at a, c (rad, right-handed). */
static void on_table(const double w[3], double a, double c, double q[3]) {
    const double s = sin(c), t = cos(c), sa = sin(a), ca = cos(a);
    const double x = w[0] - *pins->x_rot_point, y = w[1] - *pins->y_rot_point, z = w[2] - *pins->z_rot_point;
    const double qy = s * x + t * y - *pins->y_offset, qz = z - *pins->z_offset;
    q[0] = t * x - s * y + *pins->x_rot_point;
    q[1] = ca * qy - sa * qz + *pins->y_offset + *pins->y_rot_point;
    q[2] = sa * qy + ca * qz + *pins->z_offset + *pins->z_rot_point;
}

/* How far R's origin stands from the control's zero. */
static void origin_of_r(double o[3]) {
    o[0] = *pins->x_rot_point - turn_axis[0];
    o[1] = *pins->y_rot_point - turn_axis[1];
    o[2] = *pins->z_rot_point + *pins->z_offset - tilt_axis[1];
}

static void inverse(const double w[3], double tilt_deg, double turn_deg, double joint[5]) {
    const double cap = largest_turn_change * DEGREE;
    double o[3], q[3], p[3], e[6], u[3], v[3], a, c, a0, c0, turn = 0, sa;
    int step, k;
    a = a0 = tilt_sense * tilt_deg * DEGREE;
    c = c0 = turn_sense * turn_deg * DEGREE;
    origin_of_r(o);
    on_table(w, a, c, q);
    if (*pins->compensate) {
        /* the tool's axis as the work sees it */
        u[0] = sin(c) * sin(a), u[1] = cos(c) * sin(a), u[2] = cos(a);
        for (step = 0; step < 4; ++step) {
            double x, y, change;
            for (k = 0; k < 3; ++k) p[k] = q[k] - o[k];
            error_at(tilt_sense * a / DEGREE, turn_sense * c / DEGREE, p, e);
            for (k = 0; k < 3; ++k) v[k] = u[k];
            turned(0, 0, c, v);
            turned(a, 0, 0, v);
            turned(e[3], e[4], e[5], v);
            sa = sin(a);
            change = (v[0] * sa - TURNS * TURNS * turn) / (sa * sa + TURNS * TURNS);
            turn += change;
            x = turn / cap;
            y = x * x * x * x;
            c = c0 + (cap > 0 ? turn / pow(1 + y * y, 0.125) : 0);
            a += v[1];
            on_table(w, a, c, q);
        }
        for (k = 0; k < 3; ++k) p[k] = q[k] - o[k];
        for (step = 0; step < 3; ++step) {
            error_at(tilt_sense * a / DEGREE, turn_sense * c / DEGREE, p, e);
            for (k = 0; k < 3; ++k) p[k] = q[k] - o[k];
            turned(e[3], e[4], e[5], p);
            for (k = 0; k < 3; ++k) p[k] += e[k];
        }
        for (k = 0; k < 3; ++k) q[k] = p[k] + o[k];
    }
    joint[0] = q[0];
    joint[1] = q[1];
    joint[2] = q[2] + *pins->tool_offset;
    joint[3] = tilt_deg + tilt_sense * (a - a0) / DEGREE;
    joint[4] = turn_deg + turn_sense * (c - c0) / DEGREE;
}

int kinematicsInverse(const EmcPose *world, double *joint, const KINEMATICS_INVERSE_FLAGS *iflags,
                      KINEMATICS_FORWARD_FLAGS *fflags) {
    double w[3];
    (void)iflags; (void)fflags;
    w[0] = world->tran.x, w[1] = world->tran.y, w[2] = world->tran.z;
    if (switched_to == 1) {
        joint[0] = w[0], joint[1] = w[1], joint[2] = w[2], joint[3] = world->a, joint[4] = world->c;
        return 0;
    }
    inverse(w, world->a, world->c, joint);
    *pins->outside = world->a < tilt_low - 1e-6 || world->a > tilt_low + (tilt_count - 3) * tilt_step + 1e-6;
    return 0;
}

/* The world position whose inverse is `joint`: corrected by what its inverse misses, until nothing is left. */
int kinematicsForward(const double *joint, EmcPose *world, const KINEMATICS_FORWARD_FLAGS *fflags,
                      KINEMATICS_INVERSE_FLAGS *iflags) {
    double w[3], reached[5], tilt = joint[3], turn = joint[4];
    int step;
    (void)fflags; (void)iflags;
    w[0] = joint[0], w[1] = joint[1], w[2] = joint[2];
    if (switched_to == 0) {
        for (step = 0; step < 12; ++step) {
            double x, y, z, s, t, left;
            inverse(w, tilt, turn, reached);
            tilt += joint[3] - reached[3];
            turn += joint[4] - reached[4];
            x = joint[0] - reached[0], y = joint[1] - reached[1], z = joint[2] - reached[2];
            left = fabs(x) + fabs(y) + fabs(z) + fabs(joint[3] - reached[3]) + fabs(joint[4] - reached[4]);
            s = sin(tilt_sense * tilt * DEGREE), t = cos(tilt_sense * tilt * DEGREE);
            { const double yy = t * y + s * z; z = t * z - s * y; y = yy; }
            s = sin(turn_sense * turn * DEGREE), t = cos(turn_sense * turn * DEGREE);
            w[0] += t * x + s * y, w[1] += t * y - s * x, w[2] += z;
            if (left < 1e-10) break;
        }
    }
    world->tran.x = w[0], world->tran.y = w[1], world->tran.z = w[2];
    world->a = tilt, world->c = turn;
    world->b = world->u = world->v = world->w = 0;
    return 0;
}

KINEMATICS_TYPE kinematicsType(void) { return KINEMATICS_BOTH; }
int kinematicsSwitchable(void) { return 1; }
int kinematicsSwitch(int new_type) {
    if (new_type != 0 && new_type != 1) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trunnion_kins: kinematics type %d: 0 or 1 is wanted\n", new_type);
        return -1;
    }
    switched_to = new_type;
    return 0;
}

EXPORT_SYMBOL(kinematicsType);
EXPORT_SYMBOL(kinematicsSwitchable);
EXPORT_SYMBOL(kinematicsSwitch);
EXPORT_SYMBOL(kinematicsInverse);
EXPORT_SYMBOL(kinematicsForward);
)comp";

constexpr std::string_view kCoordinatesCheck = R"comp(
static int are_not_xyzac(const char *s) {
    const char *wanted = "XYZAC";
    int i;
    for (i = 0; i < 5; ++i)
        if (s[i] != wanted[i] && s[i] != wanted[i] + ('a' - 'A')) return 1;
    return s[5] != 0;
}
)comp";

std::string scalar(const char* type, const char* name, const std::string& value) {
  return std::string("static const ") + type + " " + name + " = " + value + ";\n";
}

template <class Values>
std::string array(const std::string& declaration, const Values& values, std::size_t per_line) {
  std::string text = "static const " + declaration + " = {";
  std::size_t k = 0;
  for (const auto value : values) {
    text += k % per_line == 0 ? (k == 0 ? "\n  " : ",\n  ") : ", ";
    text += shortest_text(static_cast<double>(value));
    ++k;
  }
  return text + "\n};\n";
}

}  // namespace

std::string component_source(const KinematicsData& data, const std::string& provenance) {
  std::string text(kHead);
  text += "/* Machine: " + provenance + ". Lengths mm, angles of errors rad, of axes degrees. */\n";
  text += scalar("double", "tilt_sense", shortest_text(data.tilt_sense));
  text += scalar("double", "turn_sense", shortest_text(data.turn_sense));
  text += array("double turn_axis[2]", data.turn_axis_mm, 2);
  text += array("double tilt_axis[2]", data.tilt_axis_mm, 2);
  text += scalar("double", "largest_turn_change", shortest_text(data.largest_turn_change_deg));
  text += scalar("double", "tilt_low", shortest_text(data.tilt_low_deg));
  text += scalar("double", "tilt_step", shortest_text(data.tilt_step_deg));
  text += "#define tilt_count " + std::to_string(data.tilt_count) + "\n#define turn_count " +
          std::to_string(data.turn_count) + "\n";
  text += "static const double error_map[tilt_count][turn_count][6] = {";
  for (std::size_t i = 0, k = 0; i < data.tilt_count; ++i) {
    text += i == 0 ? "\n{" : ",\n{";
    for (std::size_t j = 0; j < data.turn_count; ++j) {
      text += j == 0 ? "{" : ",\n {";
      for (int c = 0; c < 6; ++c, ++k) text += (c == 0 ? "" : ", ") + shortest_text(data.map[k]);
      text += "}";
    }
    text += "}";
  }
  text += "\n};\n";
  std::vector<double> low, step, count, first, splines;
  for (const KinematicsData::Linear& part : data.linear) {
    low.push_back(part.low_mm), step.push_back(part.step_mm);
    count.push_back(static_cast<double>(part.count)), first.push_back(static_cast<double>(splines.size() / 9));
    splines.insert(splines.end(), part.splines.begin(), part.splines.end());
  }
  if (splines.empty()) splines.assign(9, 0);
  text += array("double linear_low[3]", low, 3) + array("double linear_step[3]", step, 3);
  text += array("int linear_count[3]", count, 3) + array("int linear_first[3]", first, 3);
  text += array("double linear_splines[]", splines, 9);
  text += kCoordinatesCheck;
  text += kBody;
  return text;
}

namespace {

/// Finds what stands between `declaration` and the next ';' or end of line.
class DataReader {
 public:
  explicit DataReader(const TableFile& file) : file_(file) {}

  std::vector<double> values(const std::string& declaration) const {
    const std::size_t at = place(declaration);
    const std::size_t open = file_.text.find('=', at), end = file_.text.find(';', at);
    if (open == std::string::npos || end == std::string::npos || open > end)
      wrong(at, declaration, "= numbers; is wanted");
    std::vector<double> list;
    std::string word;
    for (std::size_t k = open + 1; k <= end; ++k) {
      const char letter = file_.text[k];
      if (std::string_view("{},; \n\r\t").find(letter) == std::string_view::npos) {
        word += letter;
      } else if (!word.empty()) {
        const auto number = number_from(word);
        if (!number) wrong(k, declaration, "\"" + word + "\" found, a number is wanted");
        list.push_back(*number);
        word.clear();
      }
    }
    return list;
  }
  double value(const std::string& declaration) const {
    const std::vector<double> list = values(declaration);
    if (list.size() != 1) wrong(place(declaration), declaration, "one number is wanted");
    return list.front();
  }
  std::size_t defined(const std::string& name) const {
    const std::string start = "#define " + name + " ";
    const std::size_t at = place(start);
    const std::size_t from = at + start.size();
    const auto number =
        integer_from(trimmed(std::string_view(file_.text).substr(from, file_.text.find('\n', at) - from)));
    if (!number || *number < 0 || *number > 100000) wrong(at, start, "a count is wanted");
    return static_cast<std::size_t>(*number);
  }
  [[noreturn]] void wrong(std::size_t at, const std::string& name, const std::string& text) const {
    const auto line = 1 + std::count(file_.text.begin(), file_.text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    throw InputError(file_.name, static_cast<std::size_t>(line), name + ": " + text);
  }

 private:
  std::size_t place(const std::string& declaration) const {
    const std::size_t at = file_.text.find(declaration);
    if (at == std::string::npos) throw InputError(file_.name, "\"" + declaration + "\" is missing");
    return at;
  }
  const TableFile& file_;
};

}  // namespace

KinematicsData read_component_data(const TableFile& file) {
  const DataReader reader(file);
  KinematicsData data;
  data.tilt_sense = reader.value("double tilt_sense");
  data.turn_sense = reader.value("double turn_sense");
  const auto fill = [&](auto& out, const std::string& declaration) {
    const std::vector<double> list = reader.values(declaration);
    if (list.size() != out.size())
      throw InputError(file.name, declaration + ": " + std::to_string(out.size()) + " numbers are wanted");
    std::ranges::copy(list, out.begin());
  };
  fill(data.turn_axis_mm, "double turn_axis[2]");
  fill(data.tilt_axis_mm, "double tilt_axis[2]");
  data.largest_turn_change_deg = reader.value("double largest_turn_change");
  data.tilt_low_deg = reader.value("double tilt_low");
  data.tilt_step_deg = reader.value("double tilt_step");
  data.tilt_count = reader.defined("tilt_count");
  data.turn_count = reader.defined("turn_count");
  data.map = reader.values("double error_map[tilt_count][turn_count][6]");
  if (data.tilt_count < 4 || data.turn_count < 4 || data.map.size() != data.tilt_count * data.turn_count * 6 ||
      !(data.tilt_step_deg > 0))
    throw InputError(file.name, "error_map: " + std::to_string(data.map.size()) + " numbers found, " +
                                    std::to_string(data.tilt_count) + " x " + std::to_string(data.turn_count) +
                                    " x 6 are wanted, at least 4 x 4");
  std::array<double, 3> low{}, step{}, count{}, first{};
  fill(low, "double linear_low[3]"), fill(step, "double linear_step[3]");
  fill(count, "int linear_count[3]"), fill(first, "int linear_first[3]");
  const std::vector<double> splines = reader.values("double linear_splines[]");
  for (std::size_t k = 0; k < 3; ++k) {
    KinematicsData::Linear& part = data.linear[k];
    part.low_mm = low[k], part.step_mm = step[k];
    if (count[k] == 0) continue;
    const double end = 9 * (first[k] + count[k]);
    if (count[k] < 4 || first[k] < 0 || !(end <= static_cast<double>(splines.size())) ||
        count[k] != std::floor(count[k]) || first[k] != std::floor(first[k]) || !(step[k] > 0))
      throw InputError(file.name, "linear_count: does not match linear_splines");
    part.count = static_cast<std::size_t>(count[k]);
    part.splines.assign(splines.begin() + static_cast<std::ptrdiff_t>(9 * first[k]),
                        splines.begin() + static_cast<std::ptrdiff_t>(end));
  }
  return data;
}

}  // namespace trunnion
