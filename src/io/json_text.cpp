#include "io/json_text.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "error.h"
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

/// Blanks without end are refused: where an error follows them, the library's message names each of them.
void check_blanks(std::string_view text, const std::string& name) {
  constexpr std::size_t kMostBlanks = std::size_t{1} << 20;
  std::size_t run = 0;
  for (const char c : text) {
    run = c == ' ' || c == '\n' || c == '\t' || c == '\r' ? run + 1 : 0;
    if (run > kMostBlanks)
      throw InputError(name, "more than " + std::to_string(kMostBlanks) + " blanks found one after another");
  }
}

}  // namespace

std::string json_text(const json& value) {
  std::string out;
  append(out, value, 0);
  return out + "\n";
}

json parse_json(std::string_view text, const std::string& name) {
  if (text.size() > kLargestJson_bytes)
    throw InputError(
        name, std::to_string(text.size()) + " bytes found, " + std::to_string(kLargestJson_bytes) + " is the most");
  check_blanks(text, name);
  constexpr int kDeepest = 32;
  // After every object the library walks over all that stand beside it: a million would take hours.
  constexpr std::size_t kMostObjects = std::size_t{1} << 16;
  constexpr std::size_t kMostKeys = std::size_t{1} << 20, kMostValues = std::size_t{1} << 24;
  std::vector<std::set<std::string>> keys;
  std::size_t object_count = 0, key_count = 0, value_count = 0;
  const json::parser_callback_t callback = [&](int depth, json::parse_event_t event, json& parsed) {
    if (depth > kDeepest) throw InputError(name, "nested more than " + std::to_string(kDeepest) + " deep");
    if (event == json::parse_event_t::object_start && ++object_count > kMostObjects)
      throw InputError(name, "more than " + std::to_string(kMostObjects) + " objects found");
    if (event == json::parse_event_t::key && ++key_count > kMostKeys)
      throw InputError(name, "more than " + std::to_string(kMostKeys) + " keys found");
    if (event == json::parse_event_t::value && ++value_count > kMostValues)
      throw InputError(name, "more than " + std::to_string(kMostValues) + " values found");
    if (event == json::parse_event_t::object_start) keys.emplace_back();
    if (event == json::parse_event_t::object_end) keys.pop_back();
    if (event == json::parse_event_t::key && !keys.back().insert(parsed.get<std::string>()).second)
      throw InputError(name, "key \"" + parsed.get<std::string>() + "\" occurs twice in one object");
    return true;
  };
  try {
    return json::parse(text.begin(), text.end(), callback);
  } catch (const json::parse_error& e) {
    std::size_t line = 1, column = 1;
    for (std::size_t i = 0; i + 1 < e.byte && i < text.size(); ++i) {
      if (text[i] == '\n')
        ++line, column = 1;
      else
        ++column;
    }
    std::string what = e.what();
    if (const std::size_t at = what.rfind("; expected"); at != std::string::npos)
      what = what.substr(at + 2) + " here";
    else if (const std::size_t error = what.rfind("syntax error"); error != std::string::npos)
      what = what.substr(error);
    for (char& c : what)
      if (static_cast<unsigned char>(c) < 0x20) c = ' ';
    throw InputError(name + ":" + std::to_string(line) + ":" + std::to_string(column) + ": not JSON: " + what);
  } catch (const json::exception& e) {
    std::string what = e.what();  // "[json.exception.…] number overflow parsing '1e999'"
    if (const std::size_t bracket = what.find("] "); bracket != std::string::npos) what.erase(0, bracket + 2);
    throw InputError(name, "not JSON: " + what);
  }
}

}  // namespace trunnion
