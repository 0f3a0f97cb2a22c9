#include "compensation/controllers/linuxcnc.h"

#include <cmath>

#include "compensation/controllers/controllers.h"
#include "compensation/number_text.h"
#include "compensation/projection.h"
#include "error.h"
#include "linear_algebra/factors.h"

namespace trunnion {
namespace linuxcnc_set {
namespace {

constexpr double kMargin_deg = 0.25;  // the correction's own step may leave the probed tilts
constexpr double kLinearStep_mm = 1;  // a screw's period is some millimetres
constexpr std::size_t kMostEntries = 256;
constexpr double kCoarsestJoint_deg = 30;
constexpr double kMapStep = 1e-12;  // of the numbers in the map, mm and rad: far below anything that moves

/// The cubic B-splines of `cells` even cells over [0, cells] that come nearest to samples at `points`: coefficients x
/// samples; `periodic` joins the ends.
Eigen::MatrixXd spline_fit(const std::vector<double>& points, Eigen::Index cells, Boundary boundary) {
  const Eigen::Index count = boundary == Boundary::repeat ? cells : cells + 3;
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(points.size()), count);
  for (std::size_t s = 0; s < points.size(); ++s) {
    const Eigen::Index cell = std::min(static_cast<Eigen::Index>(points[s]), cells - 1);
    const double u = points[s] - static_cast<double>(cell), w = 1 - u;
    const double weights[4] = {w * w * w / 6, (4 - 6 * u * u + 3 * u * u * u) / 6, (4 - 6 * w * w + 3 * w * w * w) / 6,
                               u * u * u / 6};
    for (Eigen::Index k = 0; k < 4; ++k) basis(static_cast<Eigen::Index>(s), (cell + k) % count) += weights[k];
  }
  return PivotedCholesky(basis.transpose() * basis).solve(basis.transpose());
}

/// `per_cell` samples a cell, both ends among them.
std::vector<double> samples(Eigen::Index cells, int per_cell) {
  std::vector<double> points;
  for (Eigen::Index k = 0; k <= cells * per_cell; ++k) points.push_back(static_cast<double>(k) / per_cell);
  return points;
}

double with_map_digits(double value) { return std::round(value / kMapStep) * kMapStep; }

bool is_trunnion_xyzac(const CompensationTask& task) {
  const auto along = [&](char axis, Eigen::Index k) {
    const Eigen::Vector3d d = task.machine.axes.at(axis).direction;
    return std::abs(std::abs(d[k]) - 1) < 1e-12;
  };
  return task.machine.tilt_letter() == 'A' && !task.chain.has_rotary(Side::tool) && !task.chain.turn_carries_tilt() &&
         along('A', 0) && along('C', 2) && along('X', 0) && along('Y', 1) && along('Z', 2);
}

/// Degrees of C that joint tables cover: the axis' range, or where it has none one turn to either side and one more.
Range<Angle> turn_range(const CompensationTask& task) {
  return task.machine.turn().range_angle.value_or(Range<Angle>{Angle::degrees(-360), Angle::degrees(720)});
}

JointTable tilt_joint_table(const CompensationTask& task, const std::vector<double>& nodes,
                            const std::vector<double>& values) {
  const double reversal = reversal_rad(task, task.machine.tilt_letter());
  JointTable table;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Angle forward = Angle::radians(values[k]), reverse = Angle::radians(values[k] - reversal);
    table.rows.push_back({nodes[k], forward.in_degrees(), reverse.in_degrees()});
  }
  return table;
}

/// The control smooths a trim to half the joint's speed: steeper tables would be played otherwise than they say.
void refuse_steep(const CompensationTask& task, const std::string& name, const JointTable& table) {
  const double most = task.profile.number("table_slope");
  for (std::size_t k = 1; k < table.rows.size(); ++k) {
    const JointTable::Row &before = table.rows[k - 1], &row = table.rows[k];
    const double slope = std::max(std::abs(row.forward - before.forward), std::abs(row.reverse - before.reverse)) /
                         (row.nominal - before.nominal);
    if (slope > most)
      throw RangeError(name + ": changes by " + shortest_text(rounded(slope, 6)) + " deg per deg behind " +
                       shortest_text(before.nominal) + ", profile.table_slope allows " + shortest_text(most));
  }
}

/// The spacing with which a joint table covers all of C's range, for it does not wrap.
double joint_spacing_deg(Range<Angle> c_range, Angle spacing) {
  double step = std::max(2.5, spacing.in_degrees());
  while ((c_range.high - c_range.low).in_degrees() / step + 2 > static_cast<double>(kMostEntries)) step *= 2;
  return step;
}

std::vector<TableFile> joint_tables(const CompensationTask& task, Angle spacing, Emission emission) {
  const WorkingVolume& volume = task.volume;
  const double step = spacing.in_degrees() / emission.refine;
  const std::vector<double> tilt_nodes = even_nodes(volume.a.low.in_degrees(), volume.a.high.in_degrees(), step);
  const std::vector<double> one_turn = even_nodes(0, 360, step);
  const PiecewiseLinear tilt(tilt_nodes, Boundary::hold), turn(one_turn, Boundary::repeat);
  const std::vector<double> tilt_at = tilt.sample_points(2), turn_at = turn.sample_points(2);
  const OwnAxisFit fit = own_axis_fit(task, volume_metric(task.volume), tilt_at, turn_at);
  const auto projected = [&](const PiecewiseLinear& function, const std::vector<double>& at,
                             const std::vector<double>& values) {
    const Eigen::VectorXd nodes =
        function.projector(at, reference_deg(task.volume)) *
        Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
    return std::vector<double>(nodes.begin(), nodes.end());
  };
  const JointTable tilt_table = tilt_joint_table(task, tilt_nodes, projected(tilt, tilt_at, fit.tilt_rad));
  const std::vector<double> turn_values = projected(turn, turn_at, fit.turn_rad);

  // C's table unwrapped over the whole range.
  const Range<Angle> range = turn_range(task);
  const double reversal = reversal_rad(task, 'C');
  const double node = 360.0 / static_cast<double>(one_turn.size() - 1);
  JointTable turn_table;
  for (double k = std::floor(range.low.in_degrees() / node + 1e-9);
       k <= std::ceil(range.high.in_degrees() / node - 1e-9); ++k) {
    const auto cells = static_cast<double>(one_turn.size() - 1);
    const auto index = static_cast<std::size_t>(k - cells * std::floor(k / cells));
    turn_table.rows.push_back({k * node, Angle::radians(turn_values[index]).in_degrees(),
                               Angle::radians(turn_values[index] - reversal).in_degrees()});
  }
  const std::string tilt_name(1, task.machine.tilt_letter());
  if (emission.for_the_control()) {
    refuse_steep(task, "joint_" + tilt_name + ".comp", tilt_table);
    refuse_steep(task, "joint_C.comp", turn_table);
  }
  return {{"joint_tables/joint_" + tilt_name + ".comp", joint_table_text(tilt_table, emission)},
          {"joint_tables/joint_C.comp", joint_table_text(turn_table, emission)}};
}

std::string ini_note(const CompensationTask& task) {
  return "# " + provenance(task) + "\n# Lines to merge into the machine's INI file.\n";
}

std::string limit_lines(Range<Angle> range) {
  return printed("MIN_LIMIT = %.6g\nMAX_LIMIT = %.6g\n", range.low.in_degrees(), range.high.in_degrees());
}

std::string joint_section(int joint, const std::string& lines) {
  return "\n[JOINT_" + std::to_string(joint) + "]\n" + lines;
}

std::string comp_lines(const std::string& file) { return "COMP_FILE = " + file + "\nCOMP_FILE_TYPE = 1\n"; }

std::vector<TableFile> emit(const CompensationTask& task, Angle spacing, Emission emission) {
  if (!is_trunnion_xyzac(task))
    throw RefusalError(
        "linuxcnc: structure \"" + task.machine.structure.code +
        "\": the kinematics are those of a table with C carried by A, A along X and C along Z (w C' A' …)");
  std::vector<TableFile> files;
  const KinematicsData data = kinematics_data(task, Angle::radians(spacing.in_radians() / emission.refine));
  files.push_back({"kinematics/trunnion_kins.comp", component_source(data, provenance(task))});
  const double tilt_reversal = reversal_rad(task, 'A'), turn_reversal = reversal_rad(task, 'C');
  const auto reversal_table = [&](Range<Angle> range, double reversal) {
    const double reverse = -Angle::radians(reversal).in_degrees();
    return JointTable{{{range.low.in_degrees(), 0, reverse}, {range.high.in_degrees(), 0, reverse}}};
  };
  constexpr double kNothing_rad = 1e-12;
  const bool tilt_reverses = std::abs(tilt_reversal) > kNothing_rad,
             turn_reverses = std::abs(turn_reversal) > kNothing_rad;
  const Range<Angle> c_range = turn_range(task);
  std::string kinematics_ini = ini_note(task) + "\n[KINS]\nKINEMATICS = trunnion_kins coordinates=XYZAC\nJOINTS = 5\n";
  const std::string limits = limit_lines(task.volume.a);
  kinematics_ini += "\n[AXIS_A]\n" + limits + joint_section(3, limits);
  if (tilt_reverses) {
    files.push_back(
        {"kinematics/joint_A.comp", joint_table_text(reversal_table(task.volume.a, tilt_reversal), emission)});
    kinematics_ini += comp_lines("joint_A.comp");
  }
  if (turn_reverses) {
    files.push_back({"kinematics/joint_C.comp", joint_table_text(reversal_table(c_range, turn_reversal), emission)});
    kinematics_ini += joint_section(4, comp_lines("joint_C.comp"));
  }
  if (!emission.for_the_control()) return files;

  files.push_back({"kinematics/trunnion_kins.ini", kinematics_ini});
  std::string hal =
      "# " + provenance(task) +
      "\n# Instead of the lines for xyzac-trt-kins, after [KINS]KINEMATICS and motmod are loaded. The rot-points say "
      "where\n"
      "# the axes stand in machine coordinates: here as the machine file has them, R's origin at the machine's zero.\n";
  const auto setp = [&](const char* pin, double value) {
    hal += std::string("setp trunnion_kins.") + pin + " " + shortest_text(value) + "\n";
  };
  setp("x-rot-point", data.turn_axis_mm[0]);
  setp("y-rot-point", data.turn_axis_mm[1]);
  setp("z-rot-point", data.tilt_axis_mm[1]);
  setp("y-offset", data.tilt_axis_mm[0] - data.turn_axis_mm[1]);
  setp("z-offset", 0);
  hal += "net tool-length motion.tooloffset.z => trunnion_kins.tool-offset\n";
  files.push_back({"kinematics/trunnion_kins.hal", hal});

  // The other set: at most 256 entries a joint, so C's range decides the spacing.
  if (const double joint_step = joint_spacing_deg(c_range, spacing); joint_step <= kCoarsestJoint_deg) {
    for (TableFile& file : joint_tables(task, Angle::degrees(joint_step), emission)) files.push_back(std::move(file));
    files.push_back({"joint_tables/joint_tables.ini",
                     ini_note(task) + "# C does not wrap in a joint table: its limits are what the table covers.\n" +
                         joint_section(3, comp_lines("joint_A.comp") + limits) +
                         joint_section(4, comp_lines("joint_C.comp") + limit_lines(c_range))});
  }
  return files;
}

std::string loading(const CompensationTask& task, const std::vector<TableFile>& files) {
  const auto has = [&](std::string_view name) {
    for (const TableFile& file : files)
      if (file.name == name) return true;
    return false;
  };
  std::string text = R"(## Two sets; load one

`kinematics/` is the default and carries everything. `joint_tables/` is for stock kinematics and carries only what A and C
themselves stand wrong. **Never load both**: the rotary axes would be corrected twice.

### kinematics/

1. In the folder: `sudo halcompile --install trunnion_kins.comp` (package linuxcnc-uspace-dev).
2. Merge `trunnion_kins.ini` into the machine's INI file: `[KINS]`, and the limits of A, which are those of the measured range.
)";
  if (has("kinematics/joint_A.comp") || has("kinematics/joint_C.comp"))
    text +=
        "   Copy joint_A.comp and joint_C.comp, as far as they are here, beside the INI file: they hold what depends "
        "on direction.\n";
  text +=
      R"(3. Replace the xyzac-trt-kins lines of the HAL file by `trunnion_kins.hal`; keep your own rot-points and offsets if they are
   better than the machine file's. The pins mean what they mean there.
4. Start, home, and compare the joints at A0 C0 with what they were: the correction is zero there.

`trunnion_kins.compensate` false gives the nominal kinematics; change it with the machine off only, for the joints jump by the
correction. `trunnion_kins.outside` rises where A has left the measured range.

Undo: put `xyzac-trt-kins` back into `[KINS]` and the HAL file, and take the COMP_FILE lines out.
)";
  if (has("joint_tables/joint_A.comp"))
    text += R"(
### joint_tables/

1. Copy `joint_A.comp` and `joint_C.comp` beside the INI file and merge `joint_tables.ini`. C's limits are what its table covers.
2. Restart: tables are read at start only. BACKLASH in these sections has no effect any more.

Undo: take the COMP_FILE lines out and restart.
)";
  else
    text +=
        "\n### joint_tables/\n\nNot written: a joint table does not wrap and has 256 entries at most, too few for "
        "the " +
        shortest_text((turn_range(task).high - turn_range(task).low).in_degrees()) +
        " deg of C's range at one every 30 deg.\n";
  return text;
}

}  // namespace
}  // namespace linuxcnc_set

KinematicsData kinematics_data(const CompensationTask& task, Angle spacing) {
  using namespace linuxcnc_set;
  const Machine& machine = task.machine;
  KinematicsData data;
  data.tilt_sense = machine.tilt().direction.x() < 0 ? -1 : 1;
  data.turn_sense = machine.turn().direction.z() < 0 ? -1 : 1;
  data.turn_axis_mm = {machine.turn().origin_mm.x(), machine.turn().origin_mm.y()};
  data.tilt_axis_mm = {machine.tilt().origin_mm.y(), machine.tilt().origin_mm.z()};
  data.largest_turn_change_deg = machine.limits.rotary_word.in_degrees();

  const double low = task.volume.a.low.in_degrees() - kMargin_deg, high = task.volume.a.high.in_degrees() + kMargin_deg;
  const auto tilt_cells = static_cast<Eigen::Index>(std::max(4.0, std::ceil((high - low) / spacing.in_degrees())));
  const auto turn_cells = static_cast<Eigen::Index>(std::max(6.0, std::ceil(360 / spacing.in_degrees() - 1e-9)));
  data.tilt_low_deg = low;
  data.tilt_step_deg = (high - low) / static_cast<double>(tilt_cells);
  data.tilt_count = static_cast<std::size_t>(tilt_cells + 3);
  data.turn_count = static_cast<std::size_t>(turn_cells);
  const int per_cell = spacing < Angle::degrees(2) ? 2 : 3;
  const std::vector<double> tilt_at = samples(tilt_cells, per_cell), turn_at = samples(turn_cells, per_cell);
  const auto rows = static_cast<Eigen::Index>(tilt_at.size()), columns = static_cast<Eigen::Index>(turn_at.size());
  std::array<Eigen::MatrixXd, 6> values;
  for (Eigen::MatrixXd& m : values) m.resize(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index j = 0; j < columns; ++j) {
      const Angle a = Angle::degrees(low + data.tilt_step_deg * tilt_at[static_cast<std::size_t>(i)]);
      const Angle c = Angle::degrees(360 * turn_at[static_cast<std::size_t>(j)] / static_cast<double>(turn_cells));
      const Vector6d e = rotary_part(task, {a, c}).vector();
      for (std::size_t k = 0; k < 6; ++k) values[k](i, j) = e[static_cast<Eigen::Index>(k)];
    }
  const Eigen::MatrixXd along_tilt = spline_fit(tilt_at, tilt_cells, Boundary::hold);
  const Eigen::MatrixXd along_turn = spline_fit(turn_at, turn_cells, Boundary::repeat);
  data.map.resize(data.tilt_count * data.turn_count * 6);
  for (std::size_t k = 0; k < 6; ++k) {
    const Eigen::MatrixXd coefficients = along_tilt * values[k] * along_turn.transpose();
    for (std::size_t i = 0; i < data.tilt_count; ++i)
      for (std::size_t j = 0; j < data.turn_count; ++j)
        data.map[(i * data.turn_count + j) * 6 + k] =
            with_map_digits(coefficients(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
  }

  for (const LinearPart& part : linear_parts(task, kLinearStep_mm / 2)) {
    KinematicsData::Linear& out = data.linear[static_cast<std::size_t>(part.axis - 'X')];
    const auto cells = static_cast<Eigen::Index>((part.stations_mm.size() - 1) / 2);
    const double step = (part.stations_mm.back() - part.stations_mm.front()) / static_cast<double>(cells);
    std::vector<double> points;
    for (const double station : part.stations_mm) points.push_back((station - part.stations_mm.front()) / step);
    Eigen::MatrixXd sampled(static_cast<Eigen::Index>(points.size()), 9);
    for (Eigen::Index s = 0; s < sampled.rows(); ++s) {
      const auto n = static_cast<std::size_t>(s);
      sampled.row(s) << part.table[n].transpose(), part.tip[n].transpose();
    }
    const Eigen::MatrixXd coefficients = spline_fit(points, cells, Boundary::hold) * sampled;
    out.low_mm = part.stations_mm.front();
    out.step_mm = step;
    out.count = static_cast<std::size_t>(coefficients.rows());
    for (Eigen::Index s = 0; s < coefficients.rows(); ++s)
      for (Eigen::Index k = 0; k < 9; ++k) out.splines.push_back(with_map_digits(coefficients(s, k)));
  }
  return data;
}

Controller linuxcnc() {
  using namespace linuxcnc_set;
  return {.name = "linuxcnc",
          .title = "LinuxCNC 2.9, a kinematics component of its own",
          .cannot_hold = "nothing of a rotary error map; what depends on two linear axes at once is held along each.",
          .questions = {},
          .spacings = {Angle::degrees(10), Angle::degrees(5), Angle::degrees(2.5), Angle::degrees(1)},
          .spacing_loss = Length::micrometres(0.005),
          .by_tables = false,
          .emit = emit,
          .play = play_linuxcnc,
          .loading = loading,
          .no_comments = {"joint_A.comp", "joint_C.comp"},
          .commissioning = nullptr};
}

}  // namespace trunnion
