#include "app/next_measurement.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/text_table.h"
#include "error.h"
#include "io/observation_file.h"
#include "planning/power.h"

namespace trunnion {
namespace {

constexpr std::size_t kVisits = 3;

/// The effect and the likeliest that it cannot be told from; of a smooth one only the latter, which has a formula.
std::vector<std::string> question(const AcceptedEffect& e) {
  if (e.not_separable_from.empty()) return {};
  const auto named =
      std::ranges::find_if(e.not_separable_from, [](const std::string& id) { return !id.starts_with("smooth:"); });
  std::vector<std::string> ids;
  if (!e.smooth) ids.push_back(e.effect->id());
  if (named != e.not_separable_from.end()) ids.push_back(*named);
  return ids;
}

std::string size_text(double size) { return std::isfinite(size) ? formatted("%.3g", size) : "cannot be seen"; }

NextMeasurement planned(const PowerPlan& plan, const std::vector<Spot>& spots, const ObservationSet& so_far,
                        const Machine& machine) {
  NextMeasurement next{.tilt_letter = machine.tilt_letter()};
  for (const Visit& visit : plan.visits) {
    NextMeasurement::Stop stop{
        visit.at.a.in_degrees(), visit.at.c.in_degrees(), visit.tilt_sense, visit.turn_sense, {}};
    for (const std::size_t k : visit.spots) stop.points.push_back(spots[k].point);
    next.stops.push_back(std::move(stop));
  }
  for (std::size_t k = 0; k < plan.before.size(); ++k) {
    const SmallestSeen &b = plan.before[k], &a = plan.after[k];
    next.seen.push_back(
        {b.effect, b.parameter, std::string(unit_text(b.unit).text), to_unit(b.size, b.unit), to_unit(a.size, a.unit)});
  }
  PlanOptions pace;
  for (const Observation& o : so_far.rows) pace.start_s = std::max(pace.start_s, o.time_s);
  next.rows = observations_text(planned_observations(machine, spots, plan.visits, pace, "next"), machine.tilt_letter());
  return next;
}

}  // namespace

nlohmann::json NextMeasurement::json() const {
  nlohmann::json rows_of = nlohmann::json::array(), power = nlohmann::json::array();
  const std::string tilt(1, tilt_letter);
  for (const Stop& s : stops)
    rows_of.push_back({{tilt + "_deg", s.tilt_deg},
                       {"C_deg", s.turn_deg},
                       {tilt + "_dir", s.tilt_sense},
                       {"C_dir", s.turn_sense},
                       {"points", s.points}});
  for (const Seen& s : seen) {
    const auto size = [](double x) { return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(); };
    power.push_back({{"id", s.effect},
                     {"parameter", s.parameter},
                     {"unit", s.unit},
                     {"smallest_before", size(s.before)},
                     {"smallest_after", size(s.after)}});
  }
  return {{"separate", apart}, {"file", file}, {"rows", rows_of}, {"power", power}};
}

std::string NextMeasurement::text() const {
  std::string text = "  next, as rows in " + file + ":\n";
  const auto side = [](int sense) { return sense > 0 ? "from below" : "from above"; };
  for (const Stop& s : stops)
    text += std::string("    ") + tilt_letter + formatted(" %g ", s.tilt_deg) + side(s.tilt_sense) +
            formatted(", C %g ", s.turn_deg) + side(s.turn_sense) + ": " + std::to_string(s.points.size()) +
            " touches\n";
  std::vector<std::vector<std::string>> table = {{"    found nine times in ten", "", "so far", "then", ""}};
  for (const Seen& s : seen)
    table.push_back({"    " + s.effect, s.parameter, size_text(s.before), size_text(s.after), s.unit});
  return text + text_table(table);
}

std::vector<NextMeasurement> next_measurements(const ClosureResult& result, const ObservationSet& so_far,
                                               const Machine& machine) {
  std::vector<NextMeasurement> all;
  const std::vector<Spot> spots = spots_of(so_far, KinematicChain(machine));
  if (spots.size() < 3) return all;
  for (const AcceptedEffect& e : result.effects) {
    const std::vector<std::string> ids = question(e);
    if (ids.empty()) continue;
    try {
      PlanOptions pace;
      if (const auto tilts = std::ranges::minmax(so_far.rows, {}, [](const Observation& o) { return o.at.a; });
          tilts.min.at.a < tilts.max.at.a)
        pace.tilt_low = tilts.min.at.a, pace.tilt_high = tilts.max.at.a;
      NextMeasurement next = planned(plan_for_power(so_far, machine, spots, {ids}, {.visits = kVisits, .pace = pace}),
                                     spots, so_far, machine);
      next.effect = e.effect->id();
      next.apart = ids;
      next.file = all.empty() ? "next.csv" : "next_" + std::to_string(all.size() + 1) + ".csv";
      all.push_back(std::move(next));
    } catch (const UsageError&) {  // no touch shows it: separate_by says what would
    } catch (const RangeError&) {  // nothing can be reached
    }
  }
  return all;
}

}  // namespace trunnion
