#include "compensation/controllers/sinumerik_assignments.h"

#include "compensation/number_text.h"
#include "error.h"

namespace trunnion {

SinumerikAssignments::SinumerikAssignments(const TableFile& file) : file_name_(file.name) {
  std::size_t line_number = 0;
  bool ended = false;
  for (std::string_view line : lines_of(file.text)) {
    ++line_number;
    line = trimmed(line.substr(0, line.find(';')));
    if (line.empty() || ended) continue;
    if (line == "M17" || line == "M02" || line == "M30") {
      ended = true;
      continue;
    }
    if (line.starts_with("%_N_") || line.starts_with("CHANDATA")) continue;
    const std::size_t open = line.find('['), close = line.find(']'), equals = line.find('=');
    if (line[0] != '$' || open == std::string_view::npos || close == std::string_view::npos ||
        equals == std::string_view::npos || !(open < close && close < equals))
      throw InputError(file.name, line_number, "\"" + std::string(line) + "\": $VARIABLE[index]=value is wanted");
    std::string index;
    for (const char letter : line.substr(open + 1, close - open - 1))
      if (letter != ' ' && letter != '\t') index += letter;
    const std::string name(trimmed(line.substr(0, open)));
    std::string value(trimmed(line.substr(equals + 1)));
    if (value.size() > 1 && value.front() == '(' && value.back() == ')') value = value.substr(1, value.size() - 2);
    values_[name][index] = value;
    lines_[name + "[" + index + "]"] = line_number;
  }
  if (!ended) throw InputError(file.name, line_number, "the end M17 is missing");
}

const std::string& SinumerikAssignments::text(const std::string& name, const std::string& index) const {
  const auto variable = values_.find(name);
  if (variable == values_.end() || !variable->second.contains(index))
    throw InputError(file_name_, name + "[" + index + "] is missing");
  return variable->second.at(index);
}

double SinumerikAssignments::number(const std::string& name, const std::string& index) const {
  const std::string& word = text(name, index);
  const auto value = number_from(word);
  if (!value)
    throw InputError(file_name_, lines_.at(name + "[" + index + "]"),
                     name + ": \"" + word + "\" found, a number is wanted");
  return *value;
}

const std::map<std::string, std::string>& SinumerikAssignments::all(const std::string& name) const {
  static const std::map<std::string, std::string> none;
  const auto found = values_.find(name);
  return found == values_.end() ? none : found->second;
}

}  // namespace trunnion
