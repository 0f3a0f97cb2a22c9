#include "support/observation_row.h"

#include <algorithm>
#include <charconv>
#include <functional>
#include <set>
#include <utility>

namespace trunnion::testing {
namespace {

using Field = std::function<std::optional<std::string>(const ObservationRow&)>;
using Fields = std::vector<std::pair<std::string, Field>>;

void add_vector(Fields& columns, const std::vector<std::string>& names,
                const std::function<std::optional<double>(const ObservationRow&, int)>& component,
                std::optional<int> decimals) {
  for (std::size_t i = 0; i < names.size(); ++i)
    columns.emplace_back(names[i], [=](const ObservationRow& row) -> std::optional<std::string> {
      const std::optional<double> value = component(row, static_cast<int>(i));
      if (!value) return std::nullopt;
      return csv_number(*value, decimals);
    });
}

template <class Vector>
auto component_of(std::optional<Vector> ObservationRow::*member) {
  return [member](const ObservationRow& row, int i) -> std::optional<double> {
    if (!(row.*member)) return std::nullopt;
    return (*(row.*member))[i];
  };
}

template <class Number>
Field number_of(std::optional<Number> ObservationRow::*member, std::optional<int> decimals) {
  return [=](const ObservationRow& row) -> std::optional<std::string> {
    if (!(row.*member)) return std::nullopt;
    return csv_number(static_cast<double>(*(row.*member)), decimals);
  };
}

Field text_of(std::string ObservationRow::*member) {
  return [=](const ObservationRow& row) -> std::optional<std::string> {
    if ((row.*member).empty()) return std::nullopt;
    return row.*member;
  };
}

Fields all_columns(const std::vector<ObservationRow>& rows, std::optional<int> decimals, char tilt_axis) {
  Fields columns;
  if (std::any_of(rows.begin(), rows.end(), [](const ObservationRow& row) { return row.kind != "contact"; }))
    columns.emplace_back("kind", text_of(&ObservationRow::kind));
  const std::string tilt(1, tilt_axis);
  columns.emplace_back(tilt + "_deg", [=](const ObservationRow& row) { return csv_number(row.A_deg, decimals); });
  columns.emplace_back("C_deg", [=](const ObservationRow& row) { return csv_number(row.C_deg, decimals); });
  columns.emplace_back("point", text_of(&ObservationRow::point));
  columns.emplace_back("artifact", text_of(&ObservationRow::artifact));
  add_vector(columns, {"x_mm", "y_mm", "z_mm"}, component_of(&ObservationRow::xyz_mm), decimals);
  add_vector(columns, {"nx", "ny", "nz"}, component_of(&ObservationRow::n), decimals);
  columns.emplace_back("value_um", number_of(&ObservationRow::value_um, decimals));
  add_vector(columns, {"mx", "my", "mz"}, component_of(&ObservationRow::m), decimals);
  columns.emplace_back("value_urad", number_of(&ObservationRow::value_urad, decimals));
  add_vector(columns, {"qw", "qx", "qy", "qz"}, component_of(&ObservationRow::quaternion_wxyz), decimals);
  columns.emplace_back("repeat", number_of(&ObservationRow::repeat, decimals));
  columns.emplace_back("time_s", number_of(&ObservationRow::time_s, decimals));
  columns.emplace_back(tilt + "_dir", number_of(&ObservationRow::A_dir, decimals));
  columns.emplace_back("C_dir", number_of(&ObservationRow::C_dir, decimals));
  columns.emplace_back("temperature_C", number_of(&ObservationRow::temperature_C, decimals));
  columns.emplace_back("sigma_um", number_of(&ObservationRow::sigma_um, decimals));
  std::set<std::string> extra;
  for (const ObservationRow& row : rows)
    for (const auto& [name, value] : row.covariates) extra.insert(name);
  for (const std::string& name : extra)
    columns.emplace_back(name, [=](const ObservationRow& row) -> std::optional<std::string> {
      const auto found = row.covariates.find(name);
      if (found == row.covariates.end()) return std::nullopt;
      return csv_number(found->second, decimals);
    });
  return columns;
}

}  // namespace

std::string csv_number(double value, std::optional<int> decimals) {
  char buffer[400];
  const std::to_chars_result end =
      decimals ? std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, *decimals)
               : std::to_chars(buffer, buffer + sizeof buffer, value);
  std::string text(buffer, end.ptr);
  if (decimals && text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

std::string csv(const std::vector<ObservationRow>& rows, std::optional<int> decimals, char tilt_axis) {
  Fields columns = all_columns(rows, decimals, tilt_axis);
  std::erase_if(columns, [&rows](const auto& column) {
    return std::none_of(rows.begin(), rows.end(),
                        [&](const ObservationRow& row) { return column.second(row).has_value(); });
  });
  std::string text;
  for (const auto& [name, field] : columns) text.append(name).push_back(',');
  text.back() = '\n';
  for (const ObservationRow& row : rows) {
    for (const auto& [name, field] : columns) text.append(field(row).value_or("")).push_back(',');
    text.back() = '\n';
  }
  return text;
}

}  // namespace trunnion::testing
