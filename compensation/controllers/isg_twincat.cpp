#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "compensation/at_reference.h"
#include "compensation/controllers/controllers.h"
#include "compensation/grid_table.h"
#include "compensation/number_text.h"
#include "compensation/projection.h"
#include "error.h"
#include "geometric_errors/symbol.h"

// ISG kernel and Beckhoff TwinCAT CNC, volumetric compensation (VOLC): a list file and ISG_CSV tables of ISO 230
// errors, mm and rad over mm and degrees. The control moves X, Y, Z by what the errors do to the tool's place; it does
// not turn.

namespace trunnion {
namespace isg_twincat_set {
namespace {

constexpr int kLengthDecimals = 7, kAngleDecimals = 10;
constexpr const char* kListFile = "volcomp0.lis";
constexpr const char* kTableFile = "trunnion.csv";

int decimals_of(std::size_t component) { return component < 3 ? kLengthDecimals : kAngleDecimals; }

bool values_are_added(const CompensationTask& task) {
  return task.profile.answer("volc_sense") == "values are added to the command";
}

/// Joints on the workpiece side, as the control counts them.
std::size_t workpiece_axes(const Machine& machine) {
  return static_cast<std::size_t>(std::ranges::count(machine.structure.joints, Side::workpiece, &Joint::side));
}

std::string header_of(const std::string& arguments, char axis) {
  std::string text = arguments;
  for (std::size_t k = 0; k < 6; ++k) text += " " + error_symbol(k, axis);
  return text + "\n";
}

std::string values_text(const Vector6d& values, Emission emission) {
  std::string text;
  for (std::size_t k = 0; k < 6; ++k) {
    const double value = values[static_cast<Eigen::Index>(k)];
    text += " " + (emission.quantised ? fixed_text(value, decimals_of(k)) : shortest_text(value));
  }
  return text + "\n";
}

std::vector<TableFile> emit(const CompensationTask& task, Angle spacing, Emission emission) {
  if (task.chain.has_rotary(Side::tool) || task.chain.turn_carries_tilt())
    throw RefusalError("isg-twincat: structure \"" + task.machine.structure.code +
                       "\": a table with C carried by the tilting axis is wanted");
  const double step = spacing.in_degrees() / emission.refine;
  const char tilt_letter = task.machine.tilt_letter();
  const PiecewiseLinear tilt(even_nodes(task.volume.a.low.in_degrees(), task.volume.a.high.in_degrees(), step),
                             Boundary::hold);
  const PiecewiseLinear turn(even_nodes(0, 360, step), Boundary::repeat);
  const std::vector<double> tilt_at = tilt.sample_points(2), turn_at = turn.sample_points(2);
  const ChainFit fit = chain_fit(task, tilt_at, turn_at, TurnErrors::of_both);
  const Eigen::MatrixXd over_tilt = tilt.projector(tilt_at), over_turn = turn.projector(turn_at);
  const Eigen::MatrixXd tilt_nodes = fit.tilt * over_tilt.transpose();
  const AtReference reference(task.volume, tilt, tilt_at, turn, turn_at);
  Vector6d tilt_there;
  for (Eigen::Index k = 0; k < 6; ++k) tilt_there[k] = reference.of_tilt(fit.tilt.row(k).transpose());
  const Vector6d turn_there = against_tilt(task, tilt_there);
  std::array<Eigen::MatrixXd, 6> turn_nodes;
  for (std::size_t k = 0; k < 6; ++k) {
    Eigen::MatrixXd sampled(static_cast<Eigen::Index>(tilt_at.size()), static_cast<Eigen::Index>(turn_at.size()));
    for (Eigen::Index i = 0; i < sampled.rows(); ++i)
      for (Eigen::Index j = 0; j < sampled.cols(); ++j)
        sampled(i, j) = fit.turn(static_cast<Eigen::Index>(k), i * sampled.cols() + j);
    turn_nodes[k] =
        over_tilt * reference.both(sampled, turn_there[static_cast<Eigen::Index>(k)]) * over_turn.transpose();
  }
  const std::size_t records = tilt.nodes().size() * (1 + turn.nodes().size());
  const double most = task.profile.number("volc_max_records");
  if (emission.for_the_control() && static_cast<double>(records) > most)
    throw RangeError("isg-twincat: " + std::to_string(records) +
                     " records, vol_comp.max_records (profile.volc_max_records) allows " + shortest_text(most));

  std::string table = comment_header(task, "//");
  table += "// errors of the tilting axis, errors of C over both, each where its axis stands; mm, rad over deg\n";
  // Position of the axes as constants: what A's errors are on the average, so that the maps hold the rest.
  Vector6d constant = Vector6d::Zero();
  for (const LocationError& error : location_errors(tilt_letter)) {
    const auto k = static_cast<Eigen::Index>(error.component);
    if (error.of_turning_axis) continue;
    constant[k] = rounded(tilt_nodes.row(k).mean(), decimals_of(error.component));
  }
  std::string names, values;
  for (const LocationError& error : location_errors(tilt_letter)) {
    if (error.of_turning_axis) continue;
    names += (names.empty() ? "" : " ") + error.symbol.substr(1);
    const double value = constant[static_cast<Eigen::Index>(error.component)];
    values += (values.empty() ? "" : " ") +
              (emission.quantised ? fixed_text(value, decimals_of(error.component)) : shortest_text(value));
  }
  table += names + "\n" + values + "\n#\n";
  table += header_of(std::string(1, tilt_letter), tilt_letter);
  for (std::size_t i = 0; i < tilt.nodes().size(); ++i)
    table +=
        shortest_text(tilt.nodes()[i]) + values_text(tilt_nodes.col(static_cast<Eigen::Index>(i)) - constant, emission);
  table += "#\n" + header_of(std::string(1, tilt_letter) + " C", 'C');
  for (std::size_t i = 0; i < tilt.nodes().size(); ++i)
    for (std::size_t j = 0; j < turn.nodes().size(); ++j) {
      Vector6d e;
      for (std::size_t k = 0; k < 6; ++k)
        e[static_cast<Eigen::Index>(k)] = turn_nodes[k](static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      table += shortest_text(tilt.nodes()[i]) + " " + shortest_text(turn.nodes()[j]) + values_text(e, emission);
    }
  // A linear axis that goes too far leaves the work behind: EXX is minus the deviation.
  for (const LinearPart& part : linear_parts(task, 5.0 / emission.refine)) {
    table += "#\n" + std::string(1, part.axis) + " " + error_symbol(0, part.axis) + " " + error_symbol(1, part.axis) +
             " " + error_symbol(2, part.axis) + "\n";
    for (std::size_t i = 0; i < part.stations_mm.size(); ++i) {
      const Eigen::Vector3d error = -(part.table[i].head<3>() + part.tip[i]);
      table += shortest_text(part.stations_mm[i]);
      for (Eigen::Index k = 0; k < 3; ++k)
        table += " " + (emission.quantised ? fixed_text(error[k], kLengthDecimals) : shortest_text(error[k]));
      table += "\n";
    }
  }

  std::string list = comment_header(task, "#");
  const std::map<char, long> numbers = axis_numbers(task);
  for (const char letter : {'X', 'Y', 'Z', tilt_letter, 'C'})
    list += std::string(1, letter) + " " + std::to_string(numbers.at(letter)) + "\n";
  list += "workpiece_axes " + std::to_string(workpiece_axes(task.machine)) + "\n";
  list += std::string("negate ") + (values_are_added(task) ? "TRUE" : "FALSE") + "\n";
  list +=
      "interpolation GRID\nenable_splicing FALSE\nfile[0] " + std::string(kTableFile) + "\nfile_format[0] ISG_CSV\n";
  return {{kListFile, list}, {kTableFile, table}};
}

/// One block of an ISG_CSV file: a grid over its arguments.
struct Block {
  std::vector<std::string> arguments, parameters;
  std::vector<std::vector<double>> rows;
};

bool is_argument(const std::string& name) {
  return name.size() == 1 && std::string_view("XYZABC").find(name[0]) != std::string_view::npos;
}

std::vector<Block> read_csv(const TableFile& file) {
  std::vector<Block> blocks;
  bool header_wanted = true;
  std::size_t line_number = 0;
  for (std::string_view line : lines_of(file.text)) {
    ++line_number;
    line = trimmed(line.substr(0, line.find("//")));
    if (line.empty()) continue;
    if (line == "#") {
      header_wanted = true;
      continue;
    }
    const auto words = words_of(line);
    if (header_wanted) {
      Block block;
      for (const std::string_view word : words) {
        const std::string name(word);
        if (is_argument(name) && block.parameters.empty()) {
          block.arguments.push_back(name);
        } else if (name.size() == 3 && std::string_view("XYZABCE").find(name[0]) != std::string_view::npos) {
          block.parameters.push_back(name);
        } else {
          throw InputError(
              file.name, line_number,
              "\"" + name + "\" in a header: arguments X … C first, then parameters such as EXC or Y0A are wanted");
        }
      }
      if (block.arguments.size() > 2 || block.parameters.empty())
        throw InputError(file.name, line_number,
                         "a header with at most two arguments and at least one parameter is wanted");
      blocks.push_back(block);
      header_wanted = false;
      continue;
    }
    Block& block = blocks.back();
    std::vector<double> row;
    for (const std::string_view word : words) {
      const auto number = number_from(word);
      if (!number) throw InputError(file.name, line_number, "\"" + std::string(word) + "\" found, a number is wanted");
      row.push_back(*number);
    }
    if (row.size() != block.arguments.size() + block.parameters.size())
      throw InputError(file.name, line_number,
                       std::to_string(row.size()) + " numbers found, the header has " +
                           std::to_string(block.arguments.size() + block.parameters.size()) + " columns");
    block.rows.push_back(row);
  }
  for (const Block& block : blocks)
    if (block.rows.empty()) throw InputError(file.name, line_number, "a block without rows");
  return blocks;
}

/// A parameter over no, one or two arguments, multilinear on a complete grid.
struct VolcParameter {
  std::string name;
  std::vector<std::string> arguments;
  std::vector<double> outer, inner;
  Eigen::MatrixXd values;

  double at(const std::map<std::string, double>& position) const {
    const auto of = [&](std::size_t k) { return k < arguments.size() ? position.at(arguments[k]) : 0.0; };
    if (arguments.size() == 2) return interpolated(outer, inner, values, of(0), of(1));
    if (arguments.size() == 1) {
      const std::vector<double> column(values.data(), values.data() + values.size());
      return interpolated(outer, column, Boundary::hold, of(0));
    }
    return values(0, 0);
  }
};

std::vector<VolcParameter> gridded(const Block& block, const std::string& file) {
  const std::size_t arguments = block.arguments.size();
  std::vector<double> outer, inner;
  const auto stations = [&](std::size_t k) {
    std::vector<double> list;
    for (const auto& row : block.rows) list.push_back(row[k]);
    std::ranges::sort(list);
    list.erase(std::unique(list.begin(), list.end()), list.end());
    return list;
  };
  outer = arguments > 0 ? stations(0) : std::vector<double>{0};
  inner = arguments > 1 ? stations(1) : std::vector<double>{0};
  if (block.rows.size() != outer.size() * inner.size())
    throw InputError(file, std::to_string(block.rows.size()) + " rows over " + std::to_string(outer.size()) + " x " +
                               std::to_string(inner.size()) + " stations: interpolation GRID wants a complete grid");
  std::vector<VolcParameter> parameters;
  for (std::size_t n = 0; n < block.parameters.size(); ++n) {
    VolcParameter p{block.parameters[n], block.arguments, outer, inner,
                    Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(outer.size()),
                                              static_cast<Eigen::Index>(inner.size()), std::nan(""))};
    for (const auto& row : block.rows) {
      const auto i = arguments > 0 ? std::ranges::lower_bound(outer, row[0]) - outer.begin() : 0;
      const auto j = arguments > 1 ? std::ranges::lower_bound(inner, row[1]) - inner.begin() : 0;
      p.values(i, j) = row[arguments + n];
    }
    if (p.values.array().isNaN().any())
      throw InputError(file, block.parameters[n] + ": a grid point is missing and another stands twice");
    parameters.push_back(std::move(p));
  }
  return parameters;
}

class Volc : public PlayedCompensation {
 public:
  Volc(std::vector<VolcParameter> parameters, double sense, const CompensationTask& task)
      : parameters_(std::move(parameters)), sense_(sense), tilt_letter_(task.machine.tilt_letter()) {
    for (const char letter : {tilt_letter_, 'C'}) {
      const Axis& axis = task.machine.axes.at(letter);
      origins_[letter] = axis.origin_mm;
      directions_[letter] = axis.direction;
    }
  }

  /// The chain from the slide to the table: A's errors, A's turn, C's errors; each error motion Tx Ty Tz Rx Ry Rz at
  /// its axis, before the axis turns. X, Y, Z follow the work, or run ahead of their own errors.
  AxisCorrection at(const Situation& s) const override {
    const std::map<std::string, double> position = {{"X", s.point_r_mm.x()},
                                                    {"Y", s.point_r_mm.y()},
                                                    {"Z", s.point_r_mm.z()},
                                                    {std::string(1, tilt_letter_), s.at.a.in_degrees()},
                                                    {"C", turn_in_grid(s.at.c.in_degrees())}};
    std::map<char, Vector6d> errors;
    for (const char axis : {'X', 'Y', 'Z', tilt_letter_, 'C'}) errors[axis] = Vector6d::Zero();
    for (const VolcParameter& p : parameters_) {
      const bool location = p.name[1] == '0';
      const char direction = location ? p.name[0] : p.name[1];
      const char axis = p.name[2];
      const std::size_t component = kComponentLetters.find(direction);
      if (errors.contains(axis) && component < 6) errors[axis][static_cast<Eigen::Index>(component)] += p.at(position);
    }
    const auto about = [](const Eigen::Vector3d& line, const Eigen::Isometry3d& motion) {
      return Eigen::Translation3d(line) * motion * Eigen::Translation3d(-line);
    };
    const auto motion = [](const Vector6d& e) { return transform(PoseError::from_vector(e)); };
    const auto turn = [&](char axis, double angle) {
      return about(origins_.at(axis), Eigen::Isometry3d(Eigen::AngleAxisd(angle, directions_.at(axis))));
    };
    const Eigen::Isometry3d a = turn(tilt_letter_, s.at.a.in_radians()), c = turn('C', s.at.c.in_radians());
    const Eigen::Isometry3d wrong = about(origins_.at(tilt_letter_), motion(errors.at(tilt_letter_))) * a *
                                    about(origins_.at('C'), motion(errors.at('C'))) * c;
    Eigen::Vector3d moved = wrong * (a * c).inverse() * s.point_r_mm - s.point_r_mm;
    for (const char axis : {'X', 'Y', 'Z'}) moved -= errors.at(axis).head<3>();
    return {.linear_mm = sense_ * moved};
  }

 private:
  static double turn_in_grid(double degrees) { return degrees - 360 * std::floor(degrees / 360); }

  std::vector<VolcParameter> parameters_;
  double sense_;
  char tilt_letter_;
  std::map<char, Eigen::Vector3d> origins_, directions_;
};

std::unique_ptr<PlayedCompensation> play(const std::vector<TableFile>& files, const CompensationTask& task) {
  const auto find = [&](const std::string& name) -> const TableFile& {
    const auto found = std::ranges::find(files, name, &TableFile::name);
    if (found == files.end()) throw InputError(name, "missing");
    return *found;
  };
  const TableFile& list = find(kListFile);
  bool negate = false;
  std::string table = kTableFile, interpolation = "GRID";
  std::map<char, long> wanted = axis_numbers(task);
  std::size_t line_number = 0;
  for (std::string_view line : lines_of(list.text)) {
    ++line_number;
    const auto words = words_of(trimmed(line.substr(0, line.find('#'))));
    if (words.empty()) continue;
    if (words.size() != 2) throw InputError(list.name, line_number, "a name and a value are wanted");
    const std::string name(words[0]), value(words[1]);
    if (name == "negate") {
      if (value != "TRUE" && value != "FALSE")
        throw InputError(list.name, line_number, "negate: TRUE or FALSE is wanted");
      negate = value == "TRUE";
    } else if (name == "file[0]") {
      table = value;
    } else if (name == "file_format[0]" && value != "ISG_CSV") {
      throw InputError(list.name, line_number, "file_format[0] " + value + ": only ISG_CSV is played");
    } else if (name.size() == 1 && std::string_view("XYZABC").find(name[0]) != std::string_view::npos) {
      const auto axis = wanted.find(name[0]);
      if (axis == wanted.end() || integer_from(value) != axis->second)
        throw InputError(list.name, line_number,
                         "axis " + name + " " + value + ": " +
                             (axis == wanted.end() ? "not an axis of this machine, or named before"
                                                   : "its number is " + std::to_string(axis->second)));
      wanted.erase(axis);
    } else if (name == "interpolation") {
      interpolation = value;
    } else if (name == "workpiece_axes") {
      if (integer_from(value) != static_cast<long>(workpiece_axes(task.machine)))
        throw InputError(list.name, line_number,
                         "workpiece_axes " + value + ": " + std::to_string(workpiece_axes(task.machine)) +
                             " of this machine's axes carry the workpiece");
    }
  }
  if (!wanted.empty())
    throw InputError(list.name, "the number of axis " + std::string(1, wanted.begin()->first) + " is missing");
  if (interpolation != "GRID") throw InputError(list.name, "interpolation " + interpolation + ": only GRID is played");
  std::vector<VolcParameter> parameters;
  for (const Block& block : read_csv(find(table)))
    for (VolcParameter& parameter : gridded(block, table)) parameters.push_back(std::move(parameter));
  // What the control makes of a positive value, as it was seen on the machine.
  const double plain = task.profile.answer("volc_sense") == "values are errors" ? 1 : -1;
  return std::make_unique<Volc>(std::move(parameters), negate ? -plain : plain, task);
}

std::string loading(const CompensationTask& task, const std::vector<TableFile>&) {
  return "## Steps\n\n1. Copy `" + std::string(kListFile) + "` and `" + kTableFile +
         "` to the control; write the full path of the latter behind `file[0]`.\n"
         "2. In the start-up list: `vol_comp[0].max_records " +
         shortest_text(task.profile.number("volc_max_records")) +
         "`, `vol_comp[0].file_name` = the list file (P-STUP-00100, P-STUP-00101). Restart.\n"
         "3. Reference all axes, then `#VOLCOMP ON [ID0]`. Positions change at that moment: stand clear.\n\n"
         "The files cover the tilts of the working volume; the control may refuse or extrapolate beyond: keep A "
         "inside.\n\n"
         "Undo: `#VOLCOMP OFF [ID0]`, and take the entry out of the start-up list. A reset switches it off without "
         "motion.\n";
}

/// A shift along the tilting axis' line, off the diagonal so that arguments cannot be mistaken; and a turn about Z.
std::vector<TableFile> commissioning(const CompensationTask& task) {
  const std::string a(1, task.machine.tilt_letter());
  const std::string along = error_symbol(a == "A" ? 0 : 1, 'C'), yaw = error_symbol(5, a[0]);
  std::string peak =
      comment_header(task, "//") + "// 20 um of " + along + " at " + a + " -30, C 90\n" + a + " C " + along + "\n";
  for (const char* tilt : {"-60", "-30", "0"})
    for (const char* turn : {"0", "90", "180", "360"})
      peak += std::string(tilt) + " " + turn +
              (std::string_view(tilt) == "-30" && std::string_view(turn) == "90" ? " 0.02\n" : " 0\n");
  return {{"one_peak.csv", peak},
          {"yaw_peak.csv", comment_header(task, "//") + "// 0.0001 rad of " + yaw + " at " + a + " -30\n" + a + " " +
                               yaw + "\n-60 0\n-30 0.0001\n0 0\n"}};
}

}  // namespace
}  // namespace isg_twincat_set

Controller isg_twincat() {
  using namespace isg_twincat_set;
  std::vector<ProfileNumber> numbers = {
      {"volc_max_records", "vol_comp[i].max_records of the start-up list", 2000, 10, 1e6, 1}};
  double number = 1;
  for (const char* axis : {"X", "Y", "Z", "A", "B", "C"}) {
    numbers.push_back({std::string("axis_number_") + axis, "logical number of the axis", number, 1, 64, 1});
    if (axis[0] != 'A') ++number;
  }
  return {
      .name = "isg-twincat",
      .title = "ISG kernel, Beckhoff TwinCAT CNC: volumetric compensation",
      .cannot_hold =
          "the tilt of the tool (the control moves X, Y, Z only), what depends on the sense of motion, and angular "
          "errors of linear axes.",
      .questions =
          {{{"volc_sense",
             "Does the control take table values as errors (actual minus nominal) that it takes away, or does it "
             "add them?",
             {"values are errors", "values are added to the command"},
             "Name `commissioning/one_peak.csv` behind file[0] with negate FALSE, go to {A} -30, C 90, switch #VOLCOMP "
             "ON and watch the tool: it goes by +0.02 mm along the {A} axis' line (X for A, Y for B) where values are "
             "errors, because it follows the work, by -0.02 where they are added; at {A} 0 or C 0 nothing moves."},
            {"volc_reference",
             "Are the errors of A and C taken where each axis stands (the control's own place of it, as in the machine "
             "file), before the axis' own motion (ISO 230 order)?",
             {"yes"},
             "Name `commissioning/yaw_peak.csv` behind file[0] with negate FALSE, go to {A} -30 with the tool 100 mm "
             "from the {A} axis in +Y and at its height: X moves by -0.0100 mm where values are errors, +0.0100 where "
             "they are "
             "added. -0.0087 (or +0.0087) says that the error turns with {A}."}},
           numbers},
      .spacings = {Angle::degrees(30), Angle::degrees(15), Angle::degrees(10), Angle::degrees(7.5), Angle::degrees(5),
                   Angle::degrees(3), Angle::degrees(2)},
      .spacing_loss = Length::micrometres(0.05),
      .emit = emit,
      .play = play,
      .loading = loading,
      .commissioning = commissioning};
}

}  // namespace trunnion
