#include "io/toml_reader.h"

#include <cmath>
#include <sstream>

#include "error.h"
#include "units/nearest_name.h"

namespace trunnion {
namespace {

constexpr double kLargestEntry = 1e9;  ///< mm, deg, um: far beyond any machine

std::string shown(const toml::node& node) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  node.visit([&](const auto& value) { out << value; });
  std::string text = out.str();
  for (char& c : text)
    if (c == '\n') c = ' ';
  return text.size() > 60 ? text.substr(0, 60) + "…" : text;
}

}  // namespace

toml::table TomlReader::parse(std::string_view text, const std::string& name) {
  try {
    return toml::parse(text, name);
  } catch (const toml::parse_error& e) {
    throw InputError(name, e.source().begin.line, std::string(e.description()));
  }
}

void TomlReader::fail(const std::string& key, const std::string& what) const {
  const toml::node* node = table_.get(key);
  const std::size_t line = node != nullptr ? node->source().begin.line : table_.source().begin.line;
  if (line == 0) throw InputError(file_, full(key) + ": " + what);
  throw InputError(file_, line, full(key) + ": " + what);
}

const toml::node* TomlReader::node(const std::string& key) {
  known_.push_back(key);
  return table_.get(key);
}

std::optional<std::string> TomlReader::text(const std::string& key) {
  const toml::node* found = node(key);
  if (found == nullptr) return std::nullopt;
  if (!found->is_string()) fail(key, shown(*found) + " found, a text is wanted");
  return found->as_string()->get();
}

std::optional<double> TomlReader::number(const std::string& key) {
  const toml::node* found = node(key);
  if (found == nullptr) return std::nullopt;
  const std::optional<double> value = found->is_number() ? found->value<double>() : std::nullopt;
  if (!value || !std::isfinite(*value)) fail(key, shown(*found) + " found, a finite number is wanted");
  if (std::abs(*value) > kLargestEntry) fail(key, shown(*found) + " found, a number within 1e9 is wanted");
  return value;
}

std::optional<bool> TomlReader::truth(const std::string& key) {
  const toml::node* found = node(key);
  if (found == nullptr) return std::nullopt;
  if (!found->is_boolean()) fail(key, shown(*found) + " found, true or false is wanted");
  return found->as_boolean()->get();
}

std::optional<std::vector<double>> TomlReader::numbers(const std::string& key, std::size_t count) {
  const toml::node* found = node(key);
  if (found == nullptr) return std::nullopt;
  const std::string wanted = " found, a list of " + std::to_string(count) + " finite numbers is wanted";
  if (!found->is_array() || found->as_array()->size() != count) fail(key, shown(*found) + wanted);
  std::vector<double> values;
  for (const toml::node& entry : *found->as_array()) {
    const std::optional<double> value = entry.is_number() ? entry.value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value)) fail(key, shown(*found) + wanted);
    if (std::abs(*value) > kLargestEntry) fail(key, shown(*found) + " found, numbers within 1e9 are wanted");
    values.push_back(*value);
  }
  return values;
}

std::optional<std::pair<double, double>> TomlReader::range(const std::string& key) {
  const auto values = numbers(key, 2);
  if (!values) return std::nullopt;
  if (!((*values)[0] < (*values)[1]))
    fail(key, shown(*table_.get(key)) + " found, [low, high] with low < high is wanted");
  return std::pair{(*values)[0], (*values)[1]};
}

std::optional<TomlReader> TomlReader::table(const std::string& key) {
  const toml::node* found = node(key);
  if (found == nullptr) return std::nullopt;
  if (!found->is_table()) fail(key, shown(*found) + " found, a table is wanted");
  return TomlReader(*found->as_table(), file_, full(key));
}

std::vector<std::string> TomlReader::texts(const std::string& key) {
  const toml::node* found = node(key);
  if (found == nullptr) return {};
  const std::string wanted = " found, a list of texts is wanted";
  if (!found->is_array()) fail(key, shown(*found) + wanted);
  std::vector<std::string> all;
  for (const toml::node& entry : *found->as_array()) {
    if (!entry.is_string()) fail(key, shown(*found) + wanted);
    all.push_back(entry.as_string()->get());
  }
  return all;
}

std::vector<TomlReader> TomlReader::tables(const std::string& key) {
  const toml::node* found = node(key);
  if (found == nullptr) return {};
  if (!found->is_array_of_tables()) fail(key, "[[" + full(key) + "]] is wanted");
  std::vector<TomlReader> all;
  for (const toml::node& entry : *found->as_array()) all.emplace_back(*entry.as_table(), file_, full(key));
  return all;
}

std::vector<std::string> TomlReader::keys() {
  std::vector<std::string> names;
  for (const auto& [key, value] : table_) names.emplace_back(key.str());
  known_.insert(known_.end(), names.begin(), names.end());
  return names;
}

double TomlReader::positive(const std::string& key, double otherwise) {
  const std::optional<double> value = number(key);
  if (value && !(*value > 0)) fail(key, shown(*table_.get(key)) + " found, a number above 0 is wanted");
  return value.value_or(otherwise);
}

std::string TomlReader::required_text(const std::string& key) {
  const std::optional<std::string> value = text(key);
  if (!value) throw InputError(file_, full(key) + " is missing");
  if (value->empty()) fail(key, "an empty text found");
  return *value;
}

void TomlReader::check_format(const std::string& format) {
  const std::string found = required_text("format");
  if (found != format) fail("format", "\"" + found + "\" found, \"" + format + "\" is wanted");
  const std::optional<double> version = number("version");
  if (!version) throw InputError(file_, full("version") + " is missing");
  if (*version != 1) fail("version", shown(*table_.get("version")) + " found, this program reads version 1");
}

void TomlReader::finish() const {
  for (const auto& [key, value] : table_) {
    const std::string name(key.str());
    if (std::ranges::find(known_, name) == known_.end())
      fail(name, "not a key of this table; the nearest is \"" + nearest_name(name, known_) + "\"");
  }
}

}  // namespace trunnion
