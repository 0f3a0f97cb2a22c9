#include "io/job_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>

#include "error.h"
#include "io/text_file.h"
#include "io/toml_reader.h"

namespace trunnion {
namespace {

constexpr std::size_t kLargestJob_bytes = std::size_t{1} << 24;
constexpr double kLargestLength_mm = 1e5;

/// The whole number behind `prefix`, if `text` is that and nothing else.
std::optional<int> number_behind(std::string_view text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return std::nullopt;
  text.remove_prefix(prefix.size());
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < 0) return std::nullopt;
  return number;
}

/// G54 ... G59, G59.1 ... G59.3, G54.1P1 ... G54.1P300, G500 ... G599.
bool is_work_offset(std::string_view code) {
  if (code == "G59.1" || code == "G59.2" || code == "G59.3") return true;
  if (const auto extended = number_behind(code, "G54.1P")) return *extended >= 1 && *extended <= 300;
  const auto plain = number_behind(code, "G");
  return plain && ((*plain >= 54 && *plain <= 59) || (*plain >= 500 && *plain <= 599));
}

double length(TomlReader& table, const std::string& key, std::optional<double> otherwise) {
  const std::optional<double> value = table.number(key);
  if (!value && !otherwise) table.fail(key, "is missing");
  const double result = value.value_or(otherwise.value_or(0));
  if (result < 0 || result > kLargestLength_mm) table.fail(key, "a length from 0 to 100000 mm is wanted");
  return result;
}

}  // namespace

Job parse_job(std::string_view text, const std::string& name) {
  const toml::table document = TomlReader::parse(text, name);
  TomlReader top(document, name, "");
  Job job;
  if (document.contains("format") || document.contains("version")) top.check_format("trunnion-job");
  if (auto offsets = top.table("work_offsets_mm"))
    for (const std::string& code : offsets->keys()) {
      if (!is_work_offset(code))
        offsets->fail(code,
                      "no work offset; G54 to G59, G59.1 to G59.3, G54.1P1 to G54.1P300 or G500 to G599 is wanted");
      const std::vector<double> values = *offsets->numbers(code, 3);
      for (const double value : values)
        if (std::abs(value) > kLargestLength_mm) offsets->fail(code, "offsets from -100000 to 100000 mm are wanted");
      job.work_offsets_mm[code] = {values[0], values[1], values[2]};
    }
  if (auto tools = top.table("tools"))
    for (const std::string& key : tools->keys()) {
      const auto number = number_behind(key, "T");
      if (!number) tools->fail(key, "no tool; T1, T2 and so on are wanted");
      TomlReader tool = *tools->table(key);
      job.tools[*number] = {length(tool, "length_mm", std::nullopt), length(tool, "diameter_mm", 0)};
      tool.finish();
    }
  if (auto covariates = top.table("covariates"))
    for (const std::string& key : covariates->keys()) job.covariates[key] = *covariates->number(key);
  const std::string compensated_by = top.text("compensated_by").value_or("nothing");
  if (compensated_by != "nothing" && compensated_by != "tables")
    top.fail("compensated_by", "\"" + compensated_by + "\" found, \"tables\" or \"nothing\" is wanted");
  job.tables = top.text("tables").value_or("");
  if ((compensated_by == "tables") == job.tables.empty())
    top.fail("tables", job.tables.empty()
                           ? "is missing: the folder of the tables that the control plays is wanted"
                           : "tables that nothing plays; compensated_by = \"tables\" is wanted beside it");
  top.finish();
  return job;
}

Job read_job(const std::string& path) {
  Job job = parse_job(read_text(path, kLargestJob_bytes), path);
  // Told from where the job stands.
  if (!job.tables.empty()) job.tables = (std::filesystem::path(path).parent_path() / job.tables).string();
  return job;
}

}  // namespace trunnion
