#include <algorithm>
#include <cmath>

#include "compensation/at_reference.h"
#include "compensation/controllers/controllers.h"
#include "compensation/controllers/heidenhain_files.h"
#include "compensation/number_text.h"
#include "compensation/projection.h"
#include "error.h"
#include "geometric_errors/symbol.h"
#include "units/angle.h"

// HEIDENHAIN TNC 640 and iTNC 530: axis error tables (.COM, assigned by a .CMA) of A and C, and KinematicsComp rows
// that insert the six errors of each rotary axis before its motion. Columns C1 … C6 carry X, Y, Z, A, B, C in this
// order.

namespace trunnion {
namespace heidenhain_set {
namespace {

using tnc::com_file;
using tnc::kKinematicsFile;
using tnc::kMostEntries;
using tnc::kMostInserted;

constexpr std::size_t kNumberWidth = 5, kColumnWidth = 14;

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(width, text.size() + 1), ' ');
  return text;
}

std::string signed_text(double value, int decimals, Emission emission) {
  const std::string text = emission.quantised ? fixed_text(value, decimals) : shortest_text(value);
  return text.front() == '-' ? text : "+" + text;
}

/// The component (0 … 5) that is the axis' own position, and its sign in the axis' sense.
struct Own {
  std::size_t component;
  double sense;
};
Own own_of(const Axis& axis) {
  Eigen::Index k = 0;
  axis.direction.cwiseAbs().maxCoeff(&k);
  return {3 + static_cast<std::size_t>(k), axis.direction[k] < 0 ? -1.0 : 1.0};
}

/// One table over one rotary axis: how far it stands wrong itself, in its own sense, `reversal` further after negative
/// travel, and the six extra columns; mm and degrees from mm and rad.
std::string com_text(const CompensationTask& task, const Axis& axis, const std::vector<double>& nodes,
                     const Eigen::VectorXd& own, double reversal, const Matrix6Xd& errors, Emission emission) {
  const int decimals = static_cast<int>(task.profile.number("com_decimals"));
  const double as_error = task.profile.answer("com_sign") == "error" ? 1 : -1;
  const std::size_t width = emission.quantised ? kColumnWidth : 26;
  const bool whole = task.profile.answer("com_backlash") == "value in negative travel";
  std::string text = "BEGIN " + com_file(axis.letter) + (emission.quantised ? " MM\n" : " MM UNROUNDED\n") +
                     padded("NR", kNumberWidth);
  for (const std::string& column : {std::string("AXISPOS"), std::string("BACKLASH"), std::string(1, axis.letter)})
    text += padded(column, width);
  for (int k = 1; k <= 6; ++k) text += padded("C" + std::to_string(k), width);
  text += "\n";
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const auto at = static_cast<Eigen::Index>(n);
    const auto cell = [&](double value) { return padded(signed_text(as_error * value, decimals, emission), width); };
    text += padded(std::to_string(n), kNumberWidth) + padded(signed_text(nodes[n], 4, emission), width) +
            (reversal == 0 ? padded("", width) : cell(((whole ? own[at] : 0) + reversal) / kDegree_rad)) +
            cell(own[at] / kDegree_rad);
    for (Eigen::Index k = 0; k < 6; ++k) text += cell(errors(k, at) / (k < 3 ? 1 : kDegree_rad));
    text += "\n";
  }
  return text + "[END]\n";
}

/// How much further an axis stands after negative travel; none where it is nothing.
double reversal_of(const CompensationTask& task, const Axis& axis) {
  constexpr double kNothing_rad = 1e-11;
  const double reversal = reversal_rad(task, axis.letter);
  return std::abs(reversal) < kNothing_rad ? 0 : reversal;
}

/// A row of the kinematics table: one column of one axis' table.
struct Inserted {
  char axis;
  std::size_t component;
  double gain;  ///< mean square of the deviation that it takes away, mm^2
};

/// The columns worth an entry, as many as the control's limits leave.
std::vector<Inserted> worthwhile(const CompensationTask& task, char axis, const Matrix6Xd& errors) {
  const Matrix6d metric = volume_metric(task.volume);
  std::vector<Inserted> rows;
  for (Eigen::Index k = 0; k < 6; ++k)
    rows.push_back({axis, static_cast<std::size_t>(k),
                    metric(k, k) * errors.row(k).squaredNorm() / static_cast<double>(errors.cols())});
  return rows;
}

/// Rows to be entered into the machine's kinematics table: Trans lines before the MachAxis line of their axis.
std::string kinematics_rows(const CompensationTask& task, const std::vector<Inserted>& inserted) {
  const bool by_letter = task.profile.answer("comptab_prefix") == "axis letter";
  std::string rows = comment_header(task, ";") + padded("NR", 5) + padded("DOC", 8) + padded("KEY", 10) +
                     padded("AXIS", 6) + padded("COORD", 12) + "COMPTAB\n";
  int number = 0;
  const auto row = [&](const std::string& doc, const std::string& key, char axis, const std::string& table) {
    rows += padded(std::to_string(number++), 5) + padded(doc, 8) + padded(key, 10) + padded(std::string(1, axis), 6) +
            padded("", 12) + table + "\n";
  };
  for (const char letter : {task.machine.tilt_letter(), 'C'}) {
    for (std::size_t k = 0; k < 6; ++k)
      if (std::ranges::any_of(inserted, [&](const Inserted& i) { return i.axis == letter && i.component == k; }))
        row(error_symbol(k, letter), "Trans", "XYZABC"[k],
            std::string(1, by_letter ? letter : 'A') + "..C" + std::to_string(k + 1));
    row("", "MachAxis", letter, "");
  }
  return rows;
}

std::vector<TableFile> emit(const CompensationTask& task, Angle spacing, Emission emission) {
  if (task.chain.has_rotary(Side::tool) || task.chain.turn_carries_tilt())
    throw RefusalError("heidenhain: structure \"" + task.machine.structure.code +
                       "\": a table with C carried by the tilting axis is wanted");
  const Axis &tilt_axis = task.machine.tilt(), &turn_axis = task.machine.turn();
  const double step = spacing.in_degrees() / emission.refine;
  const PiecewiseLinear tilt(even_nodes(task.volume.a.low.in_degrees(), task.volume.a.high.in_degrees(), step),
                             Boundary::hold);
  const PiecewiseLinear turn(even_nodes(0, 360, step), Boundary::repeat);
  if (emission.for_the_control() && std::max(tilt.nodes().size(), turn.nodes().size()) > kMostEntries)
    throw RangeError("heidenhain: " + std::to_string(std::max(tilt.nodes().size(), turn.nodes().size())) +
                     " entries, 256 is the most of a .COM table");
  const std::vector<double> tilt_at = tilt.sample_points(2), turn_at = turn.sample_points(2);
  const AtReference reference(task.volume, tilt, tilt_at, turn, turn_at);
  const ChainFit fit = chain_fit(task, tilt_at, turn_at, TurnErrors::of_turn_alone);
  std::vector<TableFile> files;
  std::vector<Inserted> inserted;
  // The axes themselves set the tool's axis right. How far the work is then moved X, Y and Z follow, by the component
  // that is the axis' own too.
  const OwnAxisFit own_fit = own_axis_fit(task, orientation_metric(), tilt_at, turn_at);
  const auto samples = [](const std::vector<double>& values) {
    return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  };
  const auto add_table = [&](const Axis& axis, const PiecewiseLinear& function, const std::vector<double>& at,
                             const Eigen::RowVectorXd& moved, Matrix6Xd errors) {
    errors.row(static_cast<Eigen::Index>(own_of(axis).component)) += own_of(axis).sense * moved;
    const Eigen::MatrixXd over = function.projector(at);
    const Matrix6Xd at_nodes = errors * over.transpose();
    for (const Inserted& row : worthwhile(task, axis.letter, at_nodes)) inserted.push_back(row);
    files.push_back({com_file(axis.letter), com_text(task, axis, function.nodes(), -(over * moved.transpose()),
                                                     reversal_of(task, axis), at_nodes, emission)});
  };
  add_table(tilt_axis, tilt, tilt_at, reference.tilt(samples(own_fit.tilt_rad)), fit.tilt);
  add_table(turn_axis, turn, turn_at, reference.turn(samples(own_fit.turn_rad)), fit.turn);
  std::ranges::stable_sort(inserted, std::greater<>(), &Inserted::gain);
  inserted.resize(std::min(inserted.size(), static_cast<std::size_t>(task.profile.number("comptab_entries"))));

  files.push_back({kKinematicsFile, kinematics_rows(task, inserted)});
  files.push_back({tnc::kAssignmentFile, "BEGIN CONFIG.CMA\n" + padded("NR", kNumberWidth) + padded("ACTIVE", 8) +
                                             padded(std::string(1, tilt_axis.letter), kColumnWidth) +
                                             padded("C", kColumnWidth) + "\n" + padded("0", kNumberWidth) +
                                             padded("*", 8) +
                                             padded("AXIS_" + std::string(1, tilt_axis.letter), kColumnWidth) +
                                             padded("AXIS_C", kColumnWidth) + "\n[END]\n"});
  return files;
}

std::string loading(const CompensationTask& task, const std::vector<TableFile>&) {
  const std::string a(1, task.machine.tilt_letter());
  return "## Steps\n\n1. Back up the kinematics description and the tables. Copy `AXIS_" + a +
         ".COM`, `AXIS_C.COM` and `CONFIG.CMA` to the control's table folder.\n"
         "2. Enter the rows of `" +
         std::string(kKinematicsFile) +
         "` into the machine's kinematics table, each block directly before the MachAxis line of its axis "
         "(KinematicsComp, option 52).\n"
         "3. Activate the line of the .CMA and the kinematics; reference the axes. The axes' own columns act at once: "
         "stand clear.\n\n"
         "Do not run KinematicsOpt (cycles 450 to 453) with saving afterwards: it rewrites the same "
         "description.\n\nUndo: the old kinematics table, and no active line in the .CMA.\n";
}

/// One node of 0.005 deg: in each axis' own column, and in C6 of the tilting axis with the rows that insert it.
std::vector<TableFile> commissioning(const CompensationTask& task) {
  const Axis &tilt = task.machine.tilt(), &turn = task.machine.turn();
  const double as_error = task.profile.answer("com_sign") == "error" ? 1 : -1;
  const auto peak = [&](const Axis& axis, const std::vector<double>& nodes, bool own) {
    const auto n = static_cast<Eigen::Index>(nodes.size());
    const Eigen::VectorXd at_one = as_error * 0.005 * kDegree_rad * Eigen::VectorXd::Unit(n, 1);
    Matrix6Xd errors = Matrix6Xd::Zero(6, n);
    if (!own) errors.row(5) = at_one.transpose();
    return com_text(task, axis, nodes, own ? at_one : Eigen::VectorXd::Zero(n).eval(), 0, errors, {});
  };
  return {{"own_peak_" + com_file(tilt.letter), peak(tilt, {-60, -30, 0}, true)},
          {"yaw_peak_" + com_file(tilt.letter), peak(tilt, {-60, -30, 0}, false)},
          {std::string("yaw_peak_") + kKinematicsFile, kinematics_rows(task, {{tilt.letter, 5, 0}})},
          {"turn_peak_" + com_file(turn.letter), peak(turn, {0, 30, 60, 360}, true)}};
}

}  // namespace
}  // namespace heidenhain_set

Controller heidenhain() {
  using namespace heidenhain_set;
  return {
      .name = "heidenhain",
      .title = "HEIDENHAIN TNC 640, iTNC 530: axis error tables and KinematicsComp",
      .cannot_hold =
          "errors of C that change with the tilt, what depends on the sense of motion beyond the positions of A and "
          "C themselves, and what linear axes do.",
      .questions =
          {{{"com_sign",
             "Are .COM and COMPTAB values errors that the control takes away, or corrections that it adds?",
             {"error", "correction"},
             "Load `commissioning/own_peak_AXIS_{A}.COM` as AXIS_{A}.COM, `commissioning/turn_peak_AXIS_C.COM` as "
             "AXIS_C.COM, tilt to -30 deg and read the axis against an indicator: it stands at -30.005 deg if the "
             "control "
             "takes errors away, at -29.995 if it adds corrections; likewise C at 30 deg."},
            {"comptab_prefix",
             "What stands before the column's name in COMPTAB?",
             {"axis letter", "A"},
             "Compare with a kinematics table that the control ships."},
            {"com_angles",
             "Are angular columns C4 to C6 in degrees, and is the table linear between entries?",
             {"degrees, linear"},
             "Load `commissioning/yaw_peak_AXIS_{A}.COM` as AXIS_{A}.COM with the rows of "
             "`commissioning/yaw_peak_KINEMATICS_COMP.TXT`, "
             "tilt to -30 deg: where values are errors, a point 100 mm from the axis in +Y is followed by -0.0087 mm "
             "in X "
             "(with corrections by +0.0087), half of it at -15 deg."},
            {"com_layout",
             "Does the control take this layout of columns?",
             {"yes"},
             "Import `commissioning/turn_peak_AXIS_C.COM` and look at it on the screen: 0.005 at 30 deg in C's own "
             "column."},
            {"com_backlash",
             "Does BACKLASH hold the value in negative travel itself, or its difference to that in positive travel?",
             {"value in negative travel", "difference to positive travel"},
             "Enter 0.005 for BACKLASH in every row of `commissioning/own_peak_AXIS_{A}.COM`, tilt to -30 deg from "
             "above: the axis stands at -30.005 deg if it is the value, at -30.010 if it is a difference (errors taken "
             "away).",
             true}},
           {{"com_decimals", "decimals of the values", 4, 3, 7, 1},
            {"comptab_entries",
             "entries of KinematicsComp that are free (100 less the MachAxis lines and those in use)",
             static_cast<double>(kMostInserted), 1, static_cast<double>(kMostInserted), 1}}},
      .spacings = {Angle::degrees(30), Angle::degrees(15), Angle::degrees(10), Angle::degrees(7.5), Angle::degrees(5),
                   Angle::degrees(3)},
      .emit = emit,
      .play = tnc::play,
      .loading = loading,
      .no_comments = {".COM", ".CMA"},
      .commissioning = commissioning};
}

}  // namespace trunnion
