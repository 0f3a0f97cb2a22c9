#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "compensation/controllers/heidenhain_files.h"
#include "compensation/grid_table.h"
#include "compensation/number_text.h"
#include "error.h"
#include "geometric_errors/symbol.h"
#include "units/angle.h"

// What a TNC does with the files that it was given: written from its manuals, not from the emitter.

namespace trunnion::tnc {
namespace {

/// A table between BEGIN and [END]: cells stand below the words of its heading.
struct Table {
  std::vector<std::string> heading;
  std::vector<std::vector<std::string>> rows;  ///< cells trimmed, as many as the heading has
  std::vector<std::size_t> lines;              ///< of the rows
};

Table read_table(const TableFile& file) {
  Table table;
  std::vector<std::size_t> begins;
  std::size_t line_number = 0, most = kMostEntries;
  bool begun = false, ended = false;
  for (const std::string_view line : lines_of(file.text)) {
    ++line_number;
    const auto wrong = [&](const std::string& text) { throw InputError(file.name, line_number, text); };
    if (ended) break;
    if (!begun) {
      const auto words = words_of(line);
      if (words.size() < 2 || words[0] != "BEGIN" || words[1] != file.name) wrong("BEGIN " + file.name + " is wanted");
      if (file.name.ends_with(".COM") && (words.size() < 3 || words[2] != "MM"))
        wrong("BEGIN, a name and MM are wanted");
      if (words.size() > 3 && words[3] == "UNROUNDED") most = 100000;
      begun = true;
    } else if (line == "[END]") {
      ended = true;
    } else if (table.heading.empty()) {
      for (const std::string_view word : words_of(line)) {
        table.heading.emplace_back(word);
        begins.push_back(static_cast<std::size_t>(word.data() - line.data()));
      }
      if (table.heading.size() < 3 || table.heading[0] != "NR") wrong("a heading NR … is wanted");
    } else {
      if (table.rows.size() == most) wrong("more than 256 entries");
      table.rows.emplace_back();
      table.lines.push_back(line_number);
      for (std::size_t k = 0; k < begins.size(); ++k) {
        const std::size_t from = std::min(begins[k], line.size());
        const std::size_t to = k + 1 < begins.size() ? std::min(begins[k + 1], line.size()) : line.size();
        table.rows.back().emplace_back(trimmed(line.substr(from, to - from)));
      }
    }
  }
  if (!ended) throw InputError(file.name, line_number, "[END] is missing");
  return table;
}

/// A .COM table as the control holds it: column name to values over AXISPOS. Columns without a value are none.
struct ComTable {
  std::vector<double> positions;
  std::map<std::string, std::vector<double>> columns;
};

ComTable read_com(const TableFile& file) {
  const Table table = read_table(file);
  if (table.heading.empty() || table.heading[1] != "AXISPOS")
    throw InputError(file.name, 2, "a heading NR, AXISPOS … is wanted");
  if (table.rows.size() < 2) throw InputError(file.name, 3, "two entries or more are wanted");
  ComTable com;
  for (std::size_t k = 1; k < table.heading.size(); ++k) {
    std::vector<double> values;
    bool any = false;
    for (std::size_t n = 0; n < table.rows.size(); ++n) {
      const std::string& cell = table.rows[n][k];
      const auto value = cell.empty() && k > 1 ? std::optional<double>(0) : number_from(cell);
      if (!value)
        throw InputError(
            file.name, table.lines[n],
            table.heading[k] + ": \"" + cell + "\" found, a number" + (k > 1 ? " or nothing" : "") + " is wanted");
      if (k == 1 && !values.empty() && !(*value > values.back()))
        throw InputError(file.name, table.lines[n], "AXISPOS does not ascend");
      any = any || !cell.empty();
      values.push_back(*value);
    }
    if (k == 1) com.positions = values;
    if (k > 1 && any) com.columns[table.heading[k]] = values;
  }
  return com;
}

/// The table that the active line assigns to each rotary axis.
std::map<char, std::string> read_assignment(const TableFile& file, const Machine& machine) {
  const Table table = read_table(file);
  std::optional<std::size_t> active;
  const auto column = [&](const std::string& name) {
    const auto found = std::ranges::find(table.heading, name);
    if (found == table.heading.end()) throw InputError(file.name, 2, "a column " + name + " is wanted");
    return static_cast<std::size_t>(found - table.heading.begin());
  };
  const std::size_t marks = column("ACTIVE");
  for (std::size_t n = 0; n < table.rows.size(); ++n) {
    if (table.rows[n][marks] != "*") continue;
    if (active) throw InputError(file.name, table.lines[n], "a second active line");
    active = n;
  }
  if (!active) throw InputError(file.name, "no line is active: * is wanted in the column ACTIVE of one");
  std::map<char, std::string> assigned;
  for (const char axis : {machine.tilt_letter(), 'C'}) {
    assigned[axis] = table.rows[*active][column(std::string(1, axis))] + ".COM";
    if (assigned[axis] == ".COM")
      throw InputError(file.name, table.lines[*active], std::string(1, axis) + ": no table");
  }
  return assigned;
}

class Tnc : public PlayedCompensation {
 public:
  Tnc(std::map<char, ComTable> tables, std::map<char, std::vector<std::size_t>> inserted, const CompensationTask& task)
      : tables_(std::move(tables)),
        inserted_(std::move(inserted)),
        tilt_(task.machine.tilt()),
        turn_(task.machine.turn()) {
    takes_away_ = task.profile.answer("com_sign") == "error";
    backlash_is_difference_ = task.profile.answer("com_backlash") == "difference to positive travel";
  }

  /// From the slide outward: A's errors, A, C's errors, C. The control puts the tool where the work then is.
  AxisCorrection at(const Situation& s) const override {
    const double c_deg = s.at.c.in_degrees() - 360 * std::floor(s.at.c.in_degrees() / 360);
    Eigen::Isometry3d real = Eigen::Isometry3d::Identity(), nominal = Eigen::Isometry3d::Identity();
    AxisCorrection correction;
    for (const Axis* axis : {&tilt_, &turn_}) {
      const bool tilting = axis == &tilt_;
      const ComTable& table = tables_.at(axis->letter);
      const auto column = [&](const std::string& name) {
        const auto found = table.columns.find(name);
        return found == table.columns.end() ? 0.0
                                            : interpolated(table.positions, found->second, Boundary::hold,
                                                           tilting ? s.at.a.in_degrees() : c_deg);
      };
      PoseError error;
      for (const std::size_t k : inserted_.at(axis->letter)) {
        const double value = (takes_away_ ? 1 : -1) * column("C" + std::to_string(k + 1));
        if (k < 3) error.translation_mm[static_cast<Eigen::Index>(k)] = value;
        if (k >= 3) error.rotation_rad[static_cast<Eigen::Index>(k - 3)] = value * kDegree_rad;
      }
      const Eigen::Isometry3d turned(Eigen::AngleAxisd((tilting ? s.at.a : s.at.c).in_radians(), axis->direction));
      const Eigen::Translation3d to(axis->origin_mm), from(-axis->origin_mm);
      real = real * to * transform(error) * turned * from;
      nominal = nominal * to * turned * from;
      double own = column(std::string(1, axis->letter));
      if ((tilting ? s.tilt_sense : s.turn_sense) < 0 && table.columns.contains("BACKLASH"))
        own = (backlash_is_difference_ ? own : 0) + column("BACKLASH");
      (tilting ? correction.tilt_rad : correction.turn_rad) = (takes_away_ ? -1 : 1) * own * kDegree_rad;
    }
    correction.linear_mm = real * nominal.inverse() * s.point_r_mm - s.point_r_mm;
    return correction;
  }

 private:
  std::map<char, ComTable> tables_;
  std::map<char, std::vector<std::size_t>> inserted_;
  Axis tilt_, turn_;
  bool takes_away_ = true, backlash_is_difference_ = false;
};

}  // namespace

std::unique_ptr<PlayedCompensation> play(const std::vector<TableFile>& files, const CompensationTask& task) {
  const auto find = [&](const std::string& name) -> const TableFile& {
    const auto found = std::ranges::find(files, name, &TableFile::name);
    if (found == files.end()) throw InputError(name, "missing");
    return *found;
  };
  const char tilt = task.machine.tilt_letter();
  std::map<char, ComTable> tables;
  for (const auto& [axis, name] : read_assignment(find(kAssignmentFile), task.machine))
    tables[axis] = read_com(find(name));
  // Transformations stand before the axis whose position they depend on.
  std::map<char, std::vector<std::size_t>> inserted = {{tilt, {}}, {'C', {}}};
  std::vector<std::size_t> pending;
  std::vector<std::pair<std::string, std::size_t>> prefixes;  ///< and the lines where they stand
  const bool by_letter = task.profile.answer("comptab_prefix") == "axis letter";
  const TableFile& rows = find(kKinematicsFile);
  std::size_t line_number = 0, transformations = 0;
  for (const std::string_view line : lines_of(rows.text)) {
    ++line_number;
    const auto words = words_of(line);
    if (words.empty() || line.starts_with(';') || words[0] == "NR") continue;
    const auto key = std::ranges::find_if(words, [](std::string_view w) { return w == "Trans" || w == "MachAxis"; });
    if (key == words.end() || key + 1 == words.end() || (key + 1)->size() != 1)
      throw InputError(rows.name, line_number, "KEY Trans or MachAxis and an axis are wanted");
    const char axis = (*(key + 1))[0];
    if (*key == "MachAxis") {
      if (!inserted.contains(axis))
        throw InputError(rows.name, line_number,
                         std::string("MachAxis ") + axis + ": not a rotary axis of this machine");
      const std::string prefix = by_letter ? std::string(1, axis) : "A";
      for (const auto& [found, where] : prefixes)
        if (found != prefix)
          throw InputError(rows.name, where, "COMPTAB " + found + "..: the control looks for " + prefix + "..");
      prefixes.clear();
      inserted[axis] = std::exchange(pending, {});
      continue;
    }
    const std::size_t component = kComponentLetters.find(axis);
    const std::string_view column = words.back();
    if (component == std::string_view::npos || !column.ends_with("..C" + std::to_string(component + 1)))
      throw InputError(rows.name, line_number,
                       "\"" + std::string(column) + "\": a column C1 to C6 that fits the axis is wanted");
    prefixes.emplace_back(column.substr(0, column.find("..")), line_number);
    pending.push_back(component);
    if (++transformations > kMostInserted)
      throw InputError(rows.name, line_number, "more than " + std::to_string(kMostInserted) + " entries in COMPTAB");
  }
  return std::make_unique<Tnc>(std::move(tables), std::move(inserted), task);
}

}  // namespace trunnion::tnc
