#include <algorithm>
#include <cmath>

#include "compensation/controllers/linuxcnc.h"
#include "compensation/number_text.h"
#include "error.h"

namespace trunnion {
namespace {
constexpr std::size_t kMostEntries = 256;
constexpr int kDecimals = 9;  // single precision holds fewer, and a nominal of 360 needs no more
}  // namespace

std::string joint_table_text(const JointTable& table, Emission emission) {
  std::string text;
  for (const JointTable::Row& row : table.rows)
    for (const auto& [value, end] : {std::pair(row.nominal, ' '), {row.forward, ' '}, {row.reverse, '\n'}})
      text += (emission.quantised ? fixed_text(value, kDecimals) : shortest_text(value)) + end;
  return text;
}

JointTable read_joint_table(const TableFile& file) {
  JointTable table;
  std::size_t line_number = 0;
  for (const std::string_view line : lines_of(file.text)) {
    ++line_number;
    const auto words = words_of(line);
    if (words.size() < 3) break;
    const auto nominal = number_from(words[0]), forward = number_from(words[1]), reverse = number_from(words[2]);
    if (!nominal || !forward || !reverse) break;
    if (!table.rows.empty() && *nominal <= table.rows.back().nominal)
      throw InputError(file.name, line_number,
                       "nominal " + shortest_text(*nominal) + " after " + shortest_text(table.rows.back().nominal) +
                           ", ascending ones are wanted");
    if (table.rows.size() == kMostEntries)
      throw InputError(file.name, line_number, "more than 256 entries: the control ignores the rest");
    table.rows.push_back({*nominal, *forward, *reverse});
  }
  if (table.rows.empty()) throw InputError(file.name, 1, "three numbers are wanted: nominal, forward, reverse");
  return table;
}

double joint_correction(const JointTable& table, double position, int sense) {
  const auto trim = [&](const JointTable::Row& row) {
    return static_cast<float>(sense < 0 ? row.reverse : row.forward);
  };
  const auto above = std::ranges::upper_bound(table.rows, position, {}, &JointTable::Row::nominal);
  if (above == table.rows.begin()) return static_cast<double>(trim(table.rows.front()));
  if (above == table.rows.end()) return static_cast<double>(trim(table.rows.back()));
  const JointTable::Row& low = *(above - 1);
  const auto slope = static_cast<float>((static_cast<double>(trim(*above)) - static_cast<double>(trim(low))) /
                                        (above->nominal - low.nominal));
  return static_cast<double>(trim(low)) + static_cast<double>(slope) * (position - low.nominal);
}

}  // namespace trunnion
