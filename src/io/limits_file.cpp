#include "io/limits_file.h"

#include "io/text_file.h"
#include "io/toml_reader.h"

namespace trunnion {
namespace {

constexpr std::size_t kLargestFile_bytes = std::size_t{1} << 20;

std::map<std::string, double> positive_numbers(TomlReader& top, const std::string& name) {
  std::map<std::string, double> numbers;
  if (auto table = top.table(name))
    for (const std::string& key : table->keys()) {
      numbers[key] = *table->number(key);
      if (numbers[key] <= 0) table->fail(key, "a limit above zero is wanted");
    }
  return numbers;
}

}  // namespace

AlarmLimits parse_limits(std::string_view text, const std::string& name) {
  const toml::table document = TomlReader::parse(text, name);
  TomlReader top(document, name, "");
  top.check_format("trunnion-limits");
  AlarmLimits limits{.value = positive_numbers(top, "value"), .change = positive_numbers(top, "change")};
  top.finish();
  return limits;
}

AlarmLimits read_limits(const std::string& path) { return parse_limits(read_text(path, kLargestFile_bytes), path); }

}  // namespace trunnion
