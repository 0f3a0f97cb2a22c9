#include "io/json_text.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/csv.h"

namespace trunnion {
namespace {

using nlohmann::json;

void append(std::string& out, const json& value, int indent) {
  const auto new_line = [&](int depth) { out.append("\n").append(static_cast<std::size_t>(2 * depth), ' '); };
  if (value.is_number_float()) {
    const double number = value.get<double>();
    if (std::isfinite(number))
      append_number(out, number);
    else
      out += "null";
  } else if (value.is_object() && !value.empty()) {
    out += '{';
    bool first = true;
    const auto member = [&](const std::string& key, const json& item) {
      if (!first) out += ',';
      first = false;
      new_line(indent + 1);
      out += json(key).dump() + ": ";
      append(out, item, indent + 1);
    };
    constexpr std::string_view kFirst[] = {"format", "version", "machine", "reference_pose_deg", "id", "origin"};
    for (const std::string_view key : kFirst)
      if (const auto item = value.find(key); item != value.end()) member(std::string(key), *item);
    for (const auto& [key, item] : value.items())
      if (std::ranges::find(kFirst, key) == std::end(kFirst)) member(key, item);
    new_line(indent);
    out += '}';
  } else if (value.is_array() && std::ranges::any_of(value, [](const json& item) { return item.is_structured(); })) {
    out += '[';
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (i > 0) out += ',';
      new_line(indent + 1);
      append(out, value[i], indent + 1);
    }
    new_line(indent);
    out += ']';
  } else if (value.is_array()) {
    out += '[';
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (i > 0) out += ", ";
      append(out, value[i], indent);
    }
    out += ']';
  } else {
    out += value.dump(-1, ' ', false, json::error_handler_t::replace);
  }
}

}  // namespace

std::string json_text(const json& value) {
  std::string out;
  append(out, value, 0);
  return out + "\n";
}

}  // namespace trunnion
