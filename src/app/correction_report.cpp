#include "app/correction_report.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/text_table.h"
#include "postproc/dialect.h"

namespace trunnion {
namespace {

nlohmann::json path_json(const PathError& e) {
  return {{"position_rms_um", 1e3 * e.rms_tip_mm},
          {"position_max_um", 1e3 * e.largest_tip_mm},
          {"position_max_line", e.tip_line},
          {"orientation_rms_urad", 1e6 * e.rms_tilt_rad},
          {"orientation_max_urad", 1e6 * e.largest_tilt_rad},
          {"orientation_max_line", e.tilt_line}};
}

nlohmann::json along_json(const PathTrace& along) {
  nlohmann::json j = {{"lines_per_stretch", along.lines_per_stretch()}};
  for (const char* column :
       {"line", "position_before_um", "position_after_um", "orientation_before_urad", "orientation_after_urad"})
    j[column] = nlohmann::json::array();
  for (const PathStretch& s : along.stretches()) {
    j["line"].push_back(s.line);
    j["position_before_um"].push_back(1e3 * s.tip_before_mm);
    j["position_after_um"].push_back(1e3 * s.tip_after_mm);
    j["orientation_before_urad"].push_back(1e6 * s.tilt_before_rad);
    j["orientation_after_urad"].push_back(1e6 * s.tilt_after_rad);
  }
  return j;
}

nlohmann::json limits_json(const std::vector<LimitUse>& limits) {
  const auto plain = [](double value) { return std::round(1e9 * value) / 1e9; };  // degrees were radians
  nlohmann::json list = nlohmann::json::array();
  for (const LimitUse& use : limits) {
    nlohmann::json j = {{"limit", use.limit}, {"unit", use.unit}};
    if (use.low) {
      j["used"] = {plain(*use.low), plain(use.high)};
      j["allowed"] = {plain(*use.allowed_low), plain(use.allowed_high)};
      j["lines"] = {use.low_line, use.high_line};
    } else {
      j["used"] = plain(use.high);
      j["allowed"] = plain(use.allowed_high);
      j["line"] = use.high_line;
    }
    list.push_back(std::move(j));
  }
  return list;
}

}  // namespace

nlohmann::json correction_json(const std::string& nc_program, bool orientation, const ProgramCorrection& how,
                               const ProgramCorrectionResult& result, const std::optional<PlaybackResult>& played) {
  const CorrectionCounts& c = result.counts;
  nlohmann::json json = {
      {"format", "trunnion-correction"},
      {"version", 1},
      {"nc_program", nc_program},
      {"dialect", how.dialect},
      {"tcp",
       how.scan.tcp_forced || !dialect(how.dialect).says_tcp ? (how.scan.tcp ? "on" : "off") : "as the program says"},
      {"orientation", orientation ? "on" : "off"},
      {"changed", c.changed()},
      {"lines", c.lines},
      {"corrected_blocks", c.corrected_blocks},
      {"copied_moves", c.copied_moves},
      {"changed_words", c.changed_words},
      {"added_words", c.added_words},
      {"inserted_blocks", c.inserted_blocks},
      {"blocks_beyond_tolerance", c.beyond_tolerance},
      {"largest_deviation_um", 1e3 * c.largest_deviation_mm},
      {"largest_tilt_urad", 1e6 * c.largest_tilt_rad},
      {"largest_residual_tilt_urad", 1e6 * c.largest_residual_rad},
      {"largest_C_correction_deg", Angle::radians(c.largest_c_correction_rad).in_degrees()},
      {"largest_change_per_block_um", 1e3 * c.largest_position_change_mm},
      {"largest_rotary_change_per_block_deg", Angle::radians(c.largest_rotary_change_rad).in_degrees()}};
  json["reversals_left"] = {{"count", c.reversals_left},
                            {"largest_um", 1e3 * c.largest_reversal_left_mm},
                            {"line", c.largest_reversal_left_line}};
  json["moves_of_unknown_duration"] = c.untimed_moves;
  json["assumptions"] = assumptions_met(c);
  json["refused"] = nlohmann::json::array();
  for (const Refusal& r : result.refusals) json["refused"].push_back({{"line", r.line}, {"reason", r.reason}});
  if (played)
    json["playback"] = {{"moves", played->moves},
                        {"places", played->samples},
                        {"before", path_json(played->before)},
                        {"after", path_json(played->after)},
                        {"limits", limits_json(played->limits)},
                        {"refused_blocks", played->refused},
                        {"copied_from_line", played->copied_from},
                        {"along", along_json(played->along)}};
  return json;
}

std::vector<std::string> assumptions_met(const CorrectionCounts& counts) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < kAssumptions; ++i)
    if (const auto one = static_cast<Assumption>(i); (counts.assumptions & only(one)) != 0)
      texts.emplace_back(assumption_text(one));
  return texts;
}

std::string limits_text(const PlaybackResult& played) {
  std::vector<std::vector<std::string>> rows = {{"limit", "used", "allowed", "unit", "at line"}};
  const auto range = [](std::optional<double> low, double high) {
    return (low ? formatted("%.5g ... ", *low) : std::string()) + formatted("%.5g", high);
  };
  for (const LimitUse& use : played.limits)
    rows.push_back({use.limit, range(use.low, use.high), range(use.allowed_low, use.allowed_high), use.unit,
                    (use.low ? std::to_string(use.low_line) + ", " : "") + std::to_string(use.high_line)});
  return text_table(rows);
}

std::string correction_text(const ProgramCorrectionResult& result, const std::optional<PlaybackResult>& played) {
  const CorrectionCounts& c = result.counts;
  std::string text = std::to_string(c.lines) + " lines, " + std::to_string(c.corrected_blocks) + " moves corrected, " +
                     std::to_string(c.copied_moves) + " copied (an axis not yet programmed), " +
                     std::to_string(c.changed_words) + " words changed, " + std::to_string(c.added_words) + " added, " +
                     std::to_string(c.inserted_blocks) + " blocks inserted\n";
  text += "Largest deviation " + formatted("%.2f um", 1e3 * c.largest_deviation_mm) +
          formatted(", tilt %.2f urad", 1e6 * c.largest_tilt_rad) +
          formatted(", tilt left %.2f urad", 1e6 * c.largest_residual_rad) +
          formatted(", change of C %.4f deg\n", Angle::radians(c.largest_c_correction_rad).in_degrees());
  if (!c.changed()) text += "Nothing had to be changed: the output is the input\n";
  if (played)
    text += text_table(
        {{"played back", "tip rms um", "tip max um", "at line", "axis rms urad", "axis max urad", "at line"},
         {"before", formatted("%.3f", 1e3 * played->before.rms_tip_mm),
          formatted("%.3f", 1e3 * played->before.largest_tip_mm), std::to_string(played->before.tip_line),
          formatted("%.3f", 1e6 * played->before.rms_tilt_rad),
          formatted("%.3f", 1e6 * played->before.largest_tilt_rad), std::to_string(played->before.tilt_line)},
         {"after", formatted("%.3f", 1e3 * played->after.rms_tip_mm),
          formatted("%.3f", 1e3 * played->after.largest_tip_mm), std::to_string(played->after.tip_line),
          formatted("%.3f", 1e6 * played->after.rms_tilt_rad), formatted("%.3f", 1e6 * played->after.largest_tilt_rad),
          std::to_string(played->after.tilt_line)}});
  if (played && played->refused > 0)
    text += "Played without " + std::to_string(played->refused) + " refused blocks" +
            (played->copied_from > 0 ? ", up to line " + std::to_string(played->copied_from) : "") +
            "; they are copied as they were\n";
  return text;
}

}  // namespace trunnion
