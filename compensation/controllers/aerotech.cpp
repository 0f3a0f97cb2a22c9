#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "compensation/controllers/controllers.h"
#include "compensation/grid_table.h"
#include "compensation/number_text.h"
#include "compensation/projection.h"
#include "error.h"
#include "units/angle.h"

// Aerotech A3200 and Automation1: 2-D calibration files (.cal). Tables are independent and additive, bilinear, ends
// held; positions and corrections follow the encoder's sense.

namespace trunnion {
namespace aerotech_set {
namespace {

constexpr int kDecimals = 4;               // of thousandths: 0.1 nm, 1e-7 deg
constexpr double kWorthwhile_mm2 = 1e-12;  // a nanometre
constexpr const char* kFile = "trunnion.cal";

/// One table to be written: values along rows and columns for up to three output axes, mm or degrees.
struct CalTable {
  char row_axis, column_axis;
  std::string outputs;
  std::vector<double> rows, columns;
  std::vector<Eigen::MatrixXd> values;  ///< one per output
  double gain = 0;                      ///< mean square of what it moves, mm^2
};

std::string cal_text(const CompensationTask& task, const CalTable& table, Emission emission) {
  const auto number = [&](char axis) { return shortest_text(task.profile.number(std::string("axis_number_") + axis)); };
  const auto sense = [&](char axis) { return task.profile.number(std::string("encoder_sense_") + axis); };
  const double adds = task.profile.answer("cal_sign") == "add" ? 1 : -1;
  const auto step = [](const std::vector<double>& nodes) {
    return (nodes.back() - nodes.front()) / static_cast<double>(nodes.size() - 1);
  };
  const auto distance = [&](char axis, const std::vector<double>& nodes) {
    return shortest_text(rounded(sense(axis) * step(nodes), 12));
  };
  const auto offset = [&](char axis, const std::vector<double>& nodes) {
    return shortest_text(rounded(-sense(axis) * nodes.front(), 12));
  };
  std::string text = ":START2D " + number(table.row_axis) + " " + number(table.column_axis) + " " +
                     number(table.outputs[0]) + " " + number(table.outputs[1]) + " " +
                     distance(table.row_axis, table.rows) + " " + distance(table.column_axis, table.columns) + " " +
                     std::to_string(table.columns.size()) + "\n:START2D ";
  if (table.outputs.size() == 3) text += "OUTAXIS3=" + number(table.outputs[2]) + " ";
  text += "POSUNIT=PRIMARY CORUNIT=PRIMARY/1000 OFFSETROW=" + offset(table.row_axis, table.rows) +
          " OFFSETCOL=" + offset(table.column_axis, table.columns) + "\n";
  for (Eigen::Index i = 0; i < table.values.front().rows(); ++i) {
    for (Eigen::Index j = 0; j < table.values.front().cols(); ++j)
      for (std::size_t k = 0; k < table.outputs.size(); ++k) {
        const double value = adds * sense(table.outputs[k]) * table.values[k](i, j) * 1000;
        text += (k == 0 ? (j == 0 ? "" : "  ") : " ") +
                (emission.quantised ? fixed_text(value, kDecimals) : shortest_text(value));
      }
    text += "\n";
  }
  return text + ":END\n";
}

std::vector<TableFile> emit(const CompensationTask& task, Angle spacing, Emission emission) {
  if (task.chain.has_rotary(Side::tool))
    throw RefusalError("aerotech: structure \"" + task.machine.structure.code +
                       "\": rotary axes that carry the work are wanted");
  const char a = task.machine.tilt_letter();
  // Refined nodes tell what the spacing costs; below a degree nothing of a machine is left to tell.
  const double step =
      emission.refine == 1 ? spacing.in_degrees() : std::max(1.0, spacing.in_degrees() / emission.refine);
  const PiecewiseLinear tilt(even_nodes(task.volume.a.low.in_degrees(), task.volume.a.high.in_degrees(), step),
                             Boundary::hold);
  const PiecewiseLinear turn(even_nodes(0, 360, step), Boundary::repeat);
  const std::vector<double> tilt_at = tilt.sample_points(2), turn_at = turn.sample_points(2);
  const Eigen::MatrixXd over_tilt = tilt.projector(tilt_at), over_turn = turn.projector(turn_at);
  const PairFit fit = pair_fit(task, tilt_at, turn_at);
  const auto rows_of_turn = [&](const Eigen::MatrixXd& values) {
    return Eigen::MatrixXd((over_tilt * values * over_turn.transpose()).transpose());
  };

  std::vector<CalTable> tables;
  tables.push_back({'C',
                    a,
                    "XYZ",
                    turn.nodes(),
                    tilt.nodes(),
                    {rows_of_turn(fit.shift_mm[0]), rows_of_turn(fit.shift_mm[1]), rows_of_turn(fit.shift_mm[2])}});
  tables.push_back({'C',
                    a,
                    std::string(1, a) + "C",
                    turn.nodes(),
                    tilt.nodes(),
                    {rows_of_turn(fit.tilt_rad / kDegree_rad), rows_of_turn(fit.turn_rad / kDegree_rad)}});
  // Lever arms: in proportion to X, Y, Z two rows say it exactly; what a linear axis does by itself asks for more.
  const std::vector<LinearPart> own = linear_parts(task, 10.0 / emission.refine);
  const Range<Length> strokes[3] = {task.volume.x, task.volume.y, task.volume.z};
  std::vector<CalTable> levers;
  for (Eigen::Index k = 0; k < 3; ++k)
    for (const bool of_tilt : {true, false}) {
      const char axis = static_cast<char>('X' + k);
      const auto part = of_tilt ? std::ranges::find(own, axis, &LinearPart::axis) : own.end();
      CalTable table{axis,
                     of_tilt ? a : 'C',
                     "XYZ",
                     {strokes[k].low.in_millimetres(), strokes[k].high.in_millimetres()},
                     of_tilt ? tilt.nodes() : turn.nodes(),
                     {}};
      if (part != own.end()) table.rows = part->stations_mm;
      const std::vector<Eigen::Matrix3d>& of_axis = of_tilt ? fit.tilt_lever : fit.turn_lever;
      for (Eigen::Index output = 0; output < 3; ++output) {
        Eigen::VectorXd along(static_cast<Eigen::Index>(of_axis.size()));
        for (Eigen::Index i = 0; i < along.size(); ++i) along[i] = of_axis[static_cast<std::size_t>(i)](output, k);
        const Eigen::VectorXd lever = (of_tilt ? over_tilt : over_turn) * along;
        Eigen::MatrixXd values(static_cast<Eigen::Index>(table.rows.size()), lever.size());
        for (Eigen::Index i = 0; i < values.rows(); ++i) {
          const auto n = static_cast<std::size_t>(i);
          values.row(i) = table.rows[n] * lever.transpose();
          if (part != own.end()) values.row(i).array() += part->table[n][output] + part->tip[n][output];
        }
        table.gain += values.squaredNorm() / static_cast<double>(values.size());
        table.values.push_back(values);
      }
      if (axis == 'Z')  // the axis stands above its tip by the tool
        for (double& row : table.rows) row += task.volume.tool_length.in_millimetres();
      if (table.gain > kWorthwhile_mm2) levers.push_back(std::move(table));
    }
  const double most = task.profile.number("cal_tables");
  if (emission.for_the_control() && static_cast<double>(tables.size()) > most)
    throw RangeError("aerotech: " + std::to_string(tables.size()) + " tables, profile.cal_tables allows " +
                     shortest_text(most));
  // Tables are spent where they bring most.
  std::ranges::stable_sort(levers, std::greater<>(), &CalTable::gain);
  for (CalTable& table : levers)
    if (static_cast<double>(tables.size()) < most) tables.push_back(std::move(table));

  std::string text = comment_header(task, "'");
  for (const CalTable& table : tables) {
    text += std::string("' rows over ") + table.row_axis + ", columns over " + table.column_axis + ", outputs " +
            table.outputs + "\n";
    text += cal_text(task, table, emission);
  }
  return {{kFile, text}};
}

/// A table as the file has it, numbers of axes and encoder coordinates.
struct ReadTable {
  long row_axis = 0, column_axis = 0;
  std::vector<long> outputs;
  double row_step = 0, column_step = 0, row_offset = 0, column_offset = 0;
  double correction_unit = 1;
  bool negated = false;
  std::size_t column_count = 0;
  std::vector<std::vector<double>> rows;  ///< as in the file
};

class CalReader {
 public:
  explicit CalReader(const TableFile& file) : file_(file) {}

  std::vector<ReadTable> read() {
    for (std::string_view line : lines_of(file_.text)) {
      ++line_;
      line = trimmed(line.substr(0, line.find_first_of("';")));
      if (line.empty()) continue;
      const auto words = words_of(line);
      if (words[0] == ":START2D") {
        header({words.begin() + 1, words.end()});
      } else if (words[0] == ":END") {
        finish();
      } else {
        row(words);
      }
    }
    if (open_) wrong("the last table has no :END");
    if (tables_.empty()) wrong("no table");
    return tables_;
  }

 private:
  [[noreturn]] void wrong(const std::string& text) const { throw InputError(file_.name, line_, text); }

  double number(std::string_view word) const {
    const auto value = number_from(word);
    if (!value) wrong("\"" + std::string(word) + "\" found, a number is wanted");
    return *value;
  }

  void header(const std::vector<std::string_view>& words) {
    if (!words.empty() && number_from(words[0])) {
      if (open_) wrong(":END is missing before this table");
      if (words.size() != 7) wrong("seven numbers are wanted behind :START2D");
      tables_.emplace_back();
      ReadTable& t = tables_.back();
      const auto axis = [&](std::size_t k) {
        const auto value = integer_from(words[k]);
        if (!value || *value < 1 || *value > 64) wrong("axis \"" + std::string(words[k]) + "\": 1 to 64 is wanted");
        return *value;
      };
      t.row_axis = axis(0), t.column_axis = axis(1), t.outputs = {axis(2), axis(3)};
      t.row_step = number(words[4]), t.column_step = number(words[5]);
      const auto count = integer_from(words[6]);
      if (!count || *count < 2 || *count > 100000) wrong("number of columns: 2 or more is wanted");
      if (t.row_step == 0 || t.column_step == 0) wrong("a sample distance of zero");
      t.column_count = static_cast<std::size_t>(*count);
      open_ = true;
      return;
    }
    if (!open_ || !tables_.back().rows.empty()) wrong("options stand between the first :START2D line and the rows");
    ReadTable& t = tables_.back();
    for (const std::string_view word : words) {
      const std::size_t equals = word.find('=');
      const std::string key(word.substr(0, equals));
      const std::string_view value = equals == std::string_view::npos ? std::string_view() : word.substr(equals + 1);
      if (key == "OUTAXIS3") {
        const auto axis = integer_from(value);
        if (!axis || *axis < 1 || *axis > 64) wrong("OUTAXIS3: an axis 1 to 64 is wanted");
        t.outputs.push_back(*axis);
      } else if (key == "POSUNIT") {
        if (value != "PRIMARY") wrong("POSUNIT=" + std::string(value) + ": PRIMARY is what we know");
      } else if (key == "CORUNIT") {
        if (!value.starts_with("PRIMARY"))
          wrong("CORUNIT=" + std::string(value) + ": PRIMARY, or PRIMARY/number, is wanted");
        const std::string_view rest = value.substr(7);
        t.correction_unit = rest.empty() ? 1 : 1 / number(rest.substr(1));
        if (!rest.empty() && (rest[0] != '/' || !std::isfinite(t.correction_unit)))
          wrong("CORUNIT: PRIMARY/number is wanted");
      } else if (key == "OFFSETROW") {
        t.row_offset = number(value);
      } else if (key == "OFFSETCOL") {
        t.column_offset = number(value);
      } else if (key == "NEGCOR") {
        t.negated = true;
      } else {
        wrong("\"" + key + "\": not an option we know");
      }
    }
  }

  void row(const std::vector<std::string_view>& words) {
    if (!open_) wrong("numbers outside a table");
    ReadTable& t = tables_.back();
    if (words.size() != t.column_count * t.outputs.size())
      wrong(std::to_string(words.size()) + " numbers found, " + std::to_string(t.column_count) + " groups of " +
            std::to_string(t.outputs.size()) + " are wanted");
    t.rows.emplace_back();
    for (const std::string_view word : words) t.rows.back().push_back(number(word));
  }

  void finish() {
    if (!open_) wrong(":END without :START2D");
    if (tables_.back().rows.size() < 2) wrong("a table of two rows or more is wanted");
    open_ = false;
  }

  const TableFile& file_;
  std::vector<ReadTable> tables_;
  std::size_t line_ = 0;
  bool open_ = false;
};

class Calibration : public PlayedCompensation {
 public:
  Calibration(std::vector<ReadTable> tables, const CompensationTask& task, const std::string& file)
      : tables_(std::move(tables)) {
    a_ = task.machine.tilt_letter();
    subtracts_ = task.profile.answer("cal_sign") == "subtract";
    for (const auto& [axis, number] : axis_numbers(task)) {
      letters_[number] = axis;
      counts_[axis] = task.profile.number(std::string("encoder_sense_") + axis);
    }
    for (const ReadTable& table : tables_) {
      std::vector<long> used = table.outputs;
      used.insert(used.end(), {table.row_axis, table.column_axis});
      for (const long axis : used)
        if (!letters_.contains(axis))
          throw InputError(file, "axis " + std::to_string(axis) + ": not an axis of this machine");
    }
  }

  AxisCorrection at(const Situation& s) const override {
    const std::map<char, double> position = {{'X', s.point_r_mm.x()},
                                             {'Y', s.point_r_mm.y()},
                                             {'Z', s.point_r_mm.z() + s.tool_length_mm},
                                             {a_, s.at.a.in_degrees()},
                                             {'C', s.at.c.in_degrees() - 360 * std::floor(s.at.c.in_degrees() / 360)}};
    std::map<char, double> sum;
    for (const ReadTable& t : tables_) {
      const auto index = [&](long axis, double step, double offset, std::size_t count) {
        const char letter = letters_.at(axis);
        return std::clamp((counts_.at(letter) * position.at(letter) + offset) / step, 0.0,
                          static_cast<double>(count - 1));
      };
      const double r = index(t.row_axis, t.row_step, t.row_offset, t.rows.size());
      const double c = index(t.column_axis, t.column_step, t.column_offset, t.column_count);
      const auto i = std::min(static_cast<std::size_t>(r), t.rows.size() - 2),
                 j = std::min(static_cast<std::size_t>(c), t.column_count - 2);
      const double u = r - static_cast<double>(i), v = c - static_cast<double>(j);
      const std::size_t n = t.outputs.size();
      for (std::size_t k = 0; k < n; ++k) {
        const auto value = [&](std::size_t row, std::size_t column) { return t.rows[row][column * n + k]; };
        const double between = (1 - u) * ((1 - v) * value(i, j) + v * value(i, j + 1)) +
                               u * ((1 - v) * value(i + 1, j) + v * value(i + 1, j + 1));
        const char letter = letters_.at(t.outputs[k]);
        sum[letter] += (t.negated ? -1 : 1) * (subtracts_ ? -1 : 1) * counts_.at(letter) * t.correction_unit * between;
      }
    }
    const auto of = [&](char axis) { return sum.contains(axis) ? sum.at(axis) : 0.0; };
    return {{of('X'), of('Y'), of('Z')}, of(a_) * kDegree_rad, of('C') * kDegree_rad};
  }

 private:
  std::vector<ReadTable> tables_;
  char a_;
  bool subtracts_;
  std::map<long, char> letters_;
  std::map<char, double> counts_;
};

std::unique_ptr<PlayedCompensation> play(const std::vector<TableFile>& files, const CompensationTask& task) {
  const auto found = std::ranges::find(files, kFile, &TableFile::name);
  if (found == files.end()) throw InputError(kFile, "missing");
  return std::make_unique<Calibration>(CalReader(*found).read(), task, found->name);
}

std::string loading(const CompensationTask& task, const std::vector<TableFile>&) {
  return "## Steps\n\n1. Copy `" + std::string(kFile) +
         "` to the controller; name it in the configuration, or at run time: A3200 `LOADCALFILE` with its name and "
         "`2D_CAL`, and `CALENABLE 2D`; Automation1 `CalibrationLoad()`.\n2. Home all axes before the tables are "
         "enabled: they follow encoder positions.\n"
         "3. Keep C within 0 to 360 deg, or have the axis wrap: the last row of C repeats the first, beyond it the end "
         "is held.\n\n"
         "Tables over Z assume a tool of " +
         shortest_text(task.volume.tool_length.in_millimetres()) +
         " mm: Z's position is then that much above the tip.\n\n"
         "Undo: `CALDISABLE 2D`, or unload the file.\n";
}

/// A peak off the diagonal, so that rows and columns cannot be mistaken.
std::vector<TableFile> commissioning(const CompensationTask& task) {
  const double adds = task.profile.answer("cal_sign") == "add" ? 1 : -1;
  const char a = task.machine.tilt_letter();
  CalTable table{'C', a, "XY", {0, 90, 180}, {-90, -60, -30, 0}, {}};
  table.values.assign(2, Eigen::MatrixXd::Zero(3, 4));
  table.values[0](1, 1) = adds * 0.02;
  return {{"one_peak.cal",
           comment_header(task, "'") + "' 20 um on X at C 90, " + a + " -60\n" + cal_text(task, table, {})}};
}

}  // namespace
}  // namespace aerotech_set

Controller aerotech() {
  using namespace aerotech_set;
  std::vector<ProfileNumber> numbers = {{"cal_tables", "most tables that the controller takes at once", 8, 1, 100, 1}};
  double number = 1;
  for (const char* axis : {"X", "Y", "Z", "A", "B", "C"}) {
    numbers.push_back(
        {std::string("axis_number_") + axis, "number of the axis in calibration files, from 1", number, 1, 64, 1});
    numbers.push_back({std::string("encoder_sense_") + axis,
                       "+1 where the encoder counts with the program's direction, else -1", 1, -1, 1, 2});
    if (axis[0] != 'A') ++number;
  }
  return {
      .name = "aerotech",
      .title = "Aerotech A3200 and Automation1, 2-D calibration files",
      .cannot_hold =
          "lever arms that change with A and C at once (only a function of A and one of C are added up) as far as "
          "A and C "
          "cannot take them, and what depends on the sense of motion.",
      .questions = {{{"cal_sign",
                      "Is a table's value added to the command, or taken from it?",
                      {"add", "subtract"},
                      "Load `commissioning/one_peak.cal`, go to C 90, {A} -60 and enable the table: X moves by +0.02 "
                      "mm if values are added, by -0.02 if they are taken away; at C 0 or {A} 0 nothing moves."},
                     {"encoder_senses",
                      "Do the profile's encoder_sense_X … say how each encoder counts?",
                      {"yes"},
                      "Compare the encoder's and the program's position of every axis while it moves; with "
                      "`commissioning/one_peak.cal` X moves at C 90, {A} -60 and at no other node."}},
                    numbers},
      .spacings = {Angle::degrees(30), Angle::degrees(15), Angle::degrees(10), Angle::degrees(7.5), Angle::degrees(5),
                   Angle::degrees(3)},
      .spacing_loss = Length::micrometres(0.01),
      .emit = emit,
      .play = play,
      .loading = loading,
      .commissioning = commissioning};
}

}  // namespace trunnion
