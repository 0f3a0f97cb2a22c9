#include "app/readings_input.h"

#include <algorithm>

#include "app/progress.h"
#include "io/observation_file.h"
#include "io/probe_program.h"
#include "io/text_file.h"

namespace trunnion {
namespace {

template <typename Parse>
ObservationSet parsed(const std::string& path, const Machine& machine, const Talk& talk, Parse parse) {
  const std::string text = read_text(path);
  const auto lines = static_cast<double>(std::ranges::count(text, '\n'));
  Progress progress(talk, "read " + path.substr(path.find_last_of('/') + 1), lines, "lines");
  ObservationSet set = parse(text, path, machine, [&](std::size_t read) { progress.at(static_cast<double>(read)); });
  progress.at(lines);
  return set;
}

}  // namespace

ObservationSet observations_input(const std::string& path, const Machine& machine, const Talk& talk) {
  return parsed(path, machine, talk, parse_observations);
}

ObservationSet probe_log_input(const std::string& path, const Machine& machine, const Talk& talk) {
  return parsed(path, machine, talk, parse_probe_log);
}

}  // namespace trunnion
