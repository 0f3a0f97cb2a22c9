#include "report/html.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>

#include "units/number_text.h"

namespace trunnion {
namespace {

/// Three significant digits, never an exponent; a whole number whole.
std::string plain_number(double value) {
  if (!std::isfinite(value)) return "–";
  if (std::abs(value - std::round(value)) < 1e-9 * std::max(1.0, std::abs(value))) return fixed_text(value, 0);
  const int decimals = 2 - static_cast<int>(std::floor(std::log10(std::abs(value))));
  return fixed_text(value, std::clamp(decimals, 0, 3));
}

bool is_number(const std::string& cell) {
  const std::size_t at = cell.starts_with("&lt;") ? cell.find_first_not_of(' ', 4) : 0;  // "<1e-16" is a number as well
  return at < cell.size() && (std::isdigit(static_cast<unsigned char>(cell[at])) != 0 || cell.compare(at, 3, "−") == 0);
}

/// Whether a column is one of numbers: any number in it, and nothing else but dashes.
bool is_of_numbers(const std::vector<std::vector<std::string>>& rows, std::size_t column) {
  bool any = false;
  for (const auto& row : rows) {
    if (column >= row.size() || row[column].empty() || row[column] == "–") continue;
    if (!is_number(row[column])) return false;
    any = true;
  }
  return any;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text)
    out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : std::string(1, c);
  return out;
}

std::string element(const std::string& tag, const std::string& content, const std::string& attributes) {
  return "<" + tag + (attributes.empty() ? "" : " " + attributes) + ">" + content + "</" + tag + ">\n";
}

std::string html_table(const std::string& caption, const std::vector<std::string>& head,
                       const std::vector<std::vector<std::string>>& rows) {
  std::string text = "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"" + escaped(caption) +
                     "\"><table><caption>" + escaped(caption) + "</caption>\n<thead><tr>";
  for (std::size_t k = 0; k < head.size(); ++k)
    text += (k > 0 && is_of_numbers(rows, k) ? "<th scope=\"col\" class=\"number\">" : "<th scope=\"col\">") + head[k] +
            "</th>";
  text += "</tr></thead>\n<tbody>\n";
  for (const auto& row : rows) {
    text += "<tr>";
    for (std::size_t k = 0; k < row.size(); ++k)
      text += k == 0 ? "<th scope=\"row\">" + row[k] + "</th>"
                     : std::string(is_number(row[k]) ? "<td class=\"number\">" : "<td>") + row[k] + "</td>";
    text += "</tr>\n";
  }
  return text + "</tbody></table></div>\n";
}

std::string with_true_minus(std::string text) {
  for (std::size_t at = text.find('-'); at != std::string::npos; at = text.find('-', at + 3)) text.replace(at, 1, "−");
  return text;
}

std::string unit_symbol(std::string_view unit) {
  std::string text(unit);
  if (text.starts_with("um") || text.starts_with("urad")) text.replace(0, 1, "µ");
  return text;
}

std::string quantity(double value, std::optional<double> std, std::string_view unit) {
  std::string text;
  if (std && *std > 0 && std::isfinite(*std)) {
    const int decimals = decimals_of(*std);
    text = fixed_text(value, decimals) + " ± " + fixed_text(*std, decimals);
  } else {
    text = plain_number(value);
  }
  return with_true_minus(text) + (unit.empty() ? "" : "\u00a0" + unit_symbol(unit));
}

std::string probability(double p) {
  constexpr double kPlain = 1e-3;  // from here on without an exponent
  if (!std::isfinite(p)) return "–";
  return p >= kPlain ? formatted("%.2g", p) : with_true_minus(escaped(p_value_text(p)));
}

std::optional<double> number_at(const nlohmann::json& json, const std::vector<std::string>& keys) {
  const nlohmann::json* at = &json;
  for (const std::string& key : keys) {
    if (!at->is_object() || !at->contains(key)) return std::nullopt;
    at = &(*at)[key];
  }
  return at->is_number() ? std::optional(at->get<double>()) : std::nullopt;
}

std::string text_at(const nlohmann::json& json, const std::string& key, const std::string& otherwise) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_string()) return otherwise;
  return json[key].get<std::string>();
}

std::string word_list(const nlohmann::json& list) {
  std::string text;
  if (list.is_array())
    for (const auto& item : list)
      text += (text.empty() ? "" : ", ") + escaped(item.is_string() ? item.get<std::string>() : item.dump());
  return text.empty() ? "none" : text;
}

std::string script_data(const nlohmann::json& json) {
  std::string text = json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at))
    text.replace(at, 1, "\\u003c");
  return "<script type=\"application/json\">" + text + "</script>\n";
}

}  // namespace trunnion
