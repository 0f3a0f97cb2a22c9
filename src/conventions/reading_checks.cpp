#include "conventions/reading_checks.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "conventions/nominal_fit.h"
#include "error.h"
#include "identification/free_pose_fit.h"
#include "model/catalogue.h"
#include "model/model.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr double kFits_mm = 1;  // what make_linear_problem allows a spot to stand beside its label's place
constexpr double kTwoWays = 3;  // a way to read the commands that misses less than that much more is not told
constexpr double kLineClose_mm = 0.2, kLineFar_mm = 1;  // an axis line beside its place in the file
constexpr double kPlaceOfInches_mm = 25;                // no artifact stands wholly that near to the axes' crossing
constexpr double kScatterTooSmall = 0.1;                // of the declared sigma

/// Every reading in the contact's or displacement's sense.
bool has_place(const Observation& o) { return o.kind == ReadingKind::contact || o.kind == ReadingKind::displacement; }

std::string reading_text(const AngleReading& r, char tilt) {
  std::string text;
  if (r.radians) text += "commands in rad";
  if (r.tilt_reversed) text += (text.empty() ? "" : ", ") + std::string(1, tilt) + " the other way round";
  if (r.turn_reversed) text += std::string(text.empty() ? "" : ", ") + "C the other way round";
  return text.empty() ? "the machine file" : text;
}

Check senses(const std::vector<NominalFit>& fits, char tilt) {
  Check check{.id = "senses.readings", .outcome = Outcome::passed, .found = {}, .advice = {}};
  if (fits.empty()) {
    check.outcome = Outcome::open;
    check.found =
        "no spot was seen at two positions with its place in R: these readings tell nothing of the rotation senses";
    check.advice = "make the sign test on the machine (-o DIR)";
    return check;
  }
  const NominalFit& own = fits.front();
  const auto best = std::ranges::min_element(fits.begin() + 1, fits.end(), {}, &NominalFit::rms_mm);
  check.found = "spots move with the table as the machine file says to " + formatted("%.3g", own.rms_mm) + " mm rms";
  const bool other = best != fits.end();
  if (other) check.found += "; next best: " + reading_text(best->reading, tilt) + formatted(", %.3g mm", best->rms_mm);
  if (own.rms_mm > kFits_mm) {
    check.outcome = Outcome::failed;
    if (other && best->rms_mm < own.rms_mm / kTwoWays)
      check.advice = best->reading.radians ? "commanded angles in these readings look like rad: deg are wanted"
                                           : "the readings were taken with " + reading_text(best->reading, tilt) +
                                                 ": reverse axis.*.direction, or the commands in the readings";
    else
      check.advice =
          "no sense of rotation fits: are labels mixed up, places told in another frame than R, or units mixed?";
  } else if (other && best->rms_mm < std::max(kFits_mm, kTwoWays * own.rms_mm)) {
    check.outcome = Outcome::open;
    check.advice = "these positions do not tell the two apart: make the sign test on the machine (-o DIR)";
  }
  return check;
}

Checks axis_lines(const NominalFit& fit) {
  Checks checks;
  for (std::size_t j = 0; j < fit.letters.size(); ++j) {
    const Eigen::Vector3d& off = fit.line_offset_mm[j];
    Check check{.id = std::string("origin.") + fit.letters[j], .outcome = Outcome::passed, .found = {}, .advice = {}};
    check.found = std::string("the line of ") + fit.letters[j] + " stands (" + fixed_text(off.x(), 3) + ", " +
                  fixed_text(off.y(), 3) + ", " + fixed_text(off.z(), 3) + ") mm beside its place in the machine file";
    if (off.norm() > kLineClose_mm) {
      check.outcome = off.norm() > kLineFar_mm ? Outcome::failed : Outcome::warning;
      check.advice = std::string("readings and machine file count from different zeros, or axis.") + fit.letters[j] +
                     ".origin_mm is out of date";
    }
    checks.push_back(std::move(check));
  }
  return checks;
}

Check strokes(const ObservationSet& set, const Machine& machine) {
  Check check{
      .id = "strokes", .outcome = Outcome::passed, .found = "all positions lie within the strokes", .advice = {}};
  std::size_t outside = 0;
  const auto note = [&](std::size_t row, const std::string& axis, double value, const char* unit) {
    if (outside++ == 0)
      check.found = set.place(row) + ": " + axis + formatted(" %.6g ", value) + unit + " is beyond its stroke";
  };
  for (std::size_t i = 0; i < set.rows.size(); ++i) {
    const Observation& o = set.rows[i];
    const auto& tilt = machine.tilt().range_angle;
    if (tilt && (o.at.a < tilt->low - Angle::degrees(0.1) || o.at.a > tilt->high + Angle::degrees(0.1)))
      note(i, std::string(1, machine.tilt_letter()), o.at.a.in_degrees(), "deg");
    if (!has_place(o)) continue;
    for (Eigen::Index k = 0; k < 3; ++k)
      if (const auto& stroke = machine.axes.at("XYZ"[k]).range_length;
          stroke &&
          (o.position_mm[k] < stroke->low.in_millimetres() || o.position_mm[k] > stroke->high.in_millimetres())) {
        note(i, std::string(1, "XYZ"[k]), o.position_mm[k], "mm");
        break;
      }
  }
  if (outside == 0) return check;
  check.outcome = Outcome::warning;
  check.found += outside > 1 ? ", as are " + std::to_string(outside - 1) + " more rows" : "";
  check.advice = "places are wanted in R, mm; strokes are those of the machine file";
  return check;
}

Check place_units(const ObservationSet& set) {
  double farthest = 0;
  for (const Observation& o : set.rows)
    if (has_place(o)) farthest = std::max(farthest, o.position_mm.norm());
  Check check{.id = "units.places_mm", .outcome = Outcome::passed, .found = {}, .advice = {}};
  check.found = "places reach " + formatted("%.4g", farthest) + " mm from R's origin";
  if (farthest > 0 && farthest < kPlaceOfInches_mm) {
    check.outcome = Outcome::warning;
    check.found += formatted(": inch would make it %.4g mm", 25.4 * farthest);
    check.advice = "x_mm, y_mm, z_mm are wanted in mm";
  } else if (farthest > 2e4) {
    check.outcome = Outcome::warning;
    check.advice = "um? x_mm, y_mm, z_mm are wanted in mm";
  }
  return check;
}

/// Whether all contacts lie on a grid of that step.
bool on_grid(const ObservationSet& set, double step_mm) {
  constexpr double kAside = 1e-4;  // of a step: what decimals written and read leave
  return std::ranges::all_of(set.rows, [&](const Observation& o) {
    if (o.kind != ReadingKind::contact) return true;
    const Eigen::Array3d steps = o.position_mm.array() / step_mm;
    return ((steps - steps.round()).abs() < kAside).all();
  });
}

Check reference(const ObservationSet& set) {
  Check check{.id = "reference.measured", .outcome = Outcome::passed, .found = {}, .advice = {}};
  const bool contacts =
      std::ranges::any_of(set.rows, [](const Observation& o) { return o.kind == ReadingKind::contact; });
  const std::vector<PoseGroup> groups = pose_groups(set);
  std::set<std::uint32_t> at_reference, all;
  for (const PoseGroup& group : groups)
    for (const std::size_t row : group.rows)
      if (set.rows[row].kind == ReadingKind::contact) {
        all.insert(set.rows[row].point);
        if (group.reference) at_reference.insert(set.rows[row].point);
      }
  check.found = std::to_string(groups.size()) + " positions of the rotary axes, " +
                (at_reference.empty() ? "none of them the reference pose"
                                      : std::to_string(at_reference.size()) + " of " + std::to_string(all.size()) +
                                            " spots touched at the reference pose");
  if (!contacts) {
    check.found =
        std::to_string(groups.size()) + " positions of the rotary axes; without contacts no reference pose is needed";
  } else if (at_reference.empty()) {
    check.outcome = Outcome::failed;
    check.advice = "contacts are told relative to A = C = 0: touch the spots there as well";
  } else if (at_reference.size() < all.size()) {
    check.outcome = Outcome::warning;
    check.advice = "a spot without a reference reading is an unknown of its own: touch it at A = C = 0";
  }
  return check;
}

/// A column that carries a covariate: whether it is there and moves.
struct Column {
  const char* name;
  bool present;
  double (*value)(const Observation&);
  const char* what;
};

Checks covariates(const ObservationSet& set, const Machine& machine) {
  const std::string tilt_dir = std::string(1, machine.tilt_letter()) + "_dir";
  const Column columns[] = {
      {"time_s", set.has_time, [](const Observation& o) { return o.time_s; }, "drift and creep"},
      {"temperature_C", set.has_temperature, [](const Observation& o) { return o.temperature_C; },
       "growth with temperature"},
      {tilt_dir.c_str(), set.has_tilt_sense, [](const Observation& o) { return double(o.tilt_sense); },
       "backlash of the tilting axis"},
      {"C_dir", set.has_turn_sense, [](const Observation& o) { return double(o.turn_sense); }, "backlash of C"},
      {"repeat", set.has_repeat, [](const Observation& o) { return double(o.repeat); },
       "a shift from one pass to the next"},
  };
  Checks checks;
  CandidateScope scope{
      .context = effect_context(machine), .readings = {}, .columns = set.extra_columns, .artifacts = set.artifacts};
  std::string missing, still;
  for (const Column& c : columns) {
    const auto [low, high] = std::ranges::minmax(set.rows, {}, c.value);
    std::string& list = c.present ? still : missing;
    if (c.present) scope.columns.emplace_back(c.name);
    if (!c.present || c.value(low) == c.value(high))
      list += (list.empty() ? "" : ", ") + std::string(c.name) + " (" + c.what + ")";
  }
  Check check{.id = "covariates",
              .outcome = Outcome::passed,
              .found = "time, temperature, senses of motion and passes are told, and vary",
              .advice = {}};
  if (!missing.empty() || !still.empty()) {
    check.outcome = Outcome::open;
    check.found = missing.empty() ? "" : "not told: " + missing;
    if (!still.empty())
      check.found += (missing.empty() ? "the same in all rows: " : "; the same in all rows: ") + still;
    check.advice = "what depends on these cannot be seen; write them down while measuring, and let them vary";
  }
  checks.push_back(std::move(check));
  const std::vector<Situation> all = situations(set);
  scope.readings = all;
  for (const Family& family : catalogue()) {
    if (family.name == "rotary_error_map" || family.name == "location_errors" || !family.candidates(scope).empty())
      continue;
    checks.push_back({.id = "untestable." + std::string(family.name),
                      .outcome = Outcome::open,
                      .found = std::string(family.what) + ": not testable with these readings",
                      .advice = std::string(family.remedy)});
  }
  return checks;
}

std::string pose_text(const PoseGroup& pose, char tilt) {
  return std::string(1, tilt) + formatted(" %.6g", pose.at.a.in_degrees()) +
         formatted(" C %.6g", pose.at.c.in_degrees());
}

/// What the approaches of each pose leave unseen, and touches that nothing checks.
Checks freedoms(const LinearProblem& problem, const ObservationSet& set, char tilt) {
  static constexpr const char* kComponents[] = {"Dx", "Dy", "Dz", "Da", "Db", "Dc"};
  const FreePoseFit fit = fit_free_poses(problem);
  Check seen{.id = "freedoms", .outcome = Outcome::passed, .found = {}, .advice = {}};
  seen.found = "all six freedoms of " + std::to_string(problem.poses.size()) + " positions are seen, condition " +
               formatted("%.1f", fit.condition);
  if (!fit.unseen.empty()) {
    std::set<std::uint32_t> poses;
    for (const UnseenFreedom& f : fit.unseen) poses.insert(f.pose);
    std::string components;
    for (const std::size_t c : fit.unseen.front().components)
      components += (components.empty() ? "" : ", ") + std::string(kComponents[c]);
    seen.outcome = Outcome::warning;
    seen.found = std::to_string(poses.size()) + " of " + std::to_string(problem.poses.size()) +
                 " positions leave freedoms unseen; first " + pose_text(problem.poses[fit.unseen.front().pose], tilt) +
                 ": " + components;
    seen.advice = "approach from a further direction there, or identify with --fill";
  }
  const auto unchecked = std::ranges::count_if(fit.redundancy, [](double r) { return r < 1e-6; });
  Check checked{
      .id = "redundancy", .outcome = Outcome::passed, .found = "every reading is checked by others", .advice = {}};
  if (unchecked > 0) {
    checked.outcome = Outcome::warning;
    const auto first = std::ranges::find_if(fit.redundancy, [](double r) { return r < 1e-6; }) - fit.redundancy.begin();
    checked.found = std::to_string(unchecked) + " of " + std::to_string(problem.readings.size()) +
                    " readings are checked by no other (first: " +
                    set.place(problem.readings[static_cast<std::size_t>(first)].row) + ")";
    checked.advice = "a chip on such a face goes unnoticed: touch a second spot on it";
  }
  Checks checks = {seen, checked};
  if (const auto freedom = static_cast<double>(fit.degrees_of_freedom()); freedom >= 5) {
    const double scatter = std::sqrt(fit.weighted_rss / freedom);
    Check noise{.id = "units.readings", .outcome = Outcome::passed, .found = {}, .advice = {}};
    noise.found =
        "with every position free, readings scatter " + formatted("%.2f", scatter) + " times the declared sigma";
    if (scatter < kScatterTooSmall) {
      noise.outcome = Outcome::warning;
      noise.advice =
          "too good for a probe: mm or inch where um and mm are wanted, computed data, or a sigma_um far too large";
    }
    checks.push_back(std::move(noise));
  }
  return checks;
}

}  // namespace

double coordinate_step_mm(const ObservationSet& observations) {
  constexpr std::ptrdiff_t kFewest = 30;
  const auto contacts = std::ranges::count(observations.rows, ReadingKind::contact, &Observation::kind);
  if (contacts < kFewest) return 0;
  for (double power = 0.1; power > 5e-6; power /= 10)
    for (const double digit : {1.0, 0.5, 0.2})
      if (on_grid(observations, digit * power)) return digit * power;
  return 0;
}

Check rounding_check(const ObservationSet& observations, const Machine& machine) {
  Check check{.id = "units.rounding", .outcome = Outcome::passed, .found = {}, .advice = {}};
  const double step_um = 1e3 * coordinate_step_mm(observations), scatter_um = step_um / std::sqrt(12.0);
  double least_um = 1e3 * machine.probe.sigma.in_millimetres();
  for (const Observation& o : observations.rows)
    if (o.kind == ReadingKind::contact && o.sigma > 0) least_um = std::min(least_um, 1e3 * o.sigma);
  check.found =
      step_um > 0 ? "contacts are multiples of " + formatted("%.4g", step_um) + " um" : "contacts are told finely";
  if (scatter_um > least_um) {
    check.outcome = Outcome::warning;
    check.found += formatted(": rounding alone scatters by %.3g um,", scatter_um) +
                   formatted(" the declared sigma is %.3g um", least_um);
    check.advice =
        "declare a sigma_um of " + formatted("%.3g", scatter_um) + " at least, or have more decimals written";
  }
  return check;
}

Checks reading_checks(const ObservationSet& observations, const Machine& machine) {
  Checks checks;
  const auto add = [&](Checks more) {
    for (Check& check : more) checks.push_back(std::move(check));
  };
  const std::vector<NominalFit> fits = nominal_fits(observations, machine);
  checks.push_back(senses(fits, machine.tilt_letter()));
  const bool moves_right = checks.back().outcome != Outcome::failed;
  if (!fits.empty() && moves_right) add(axis_lines(fits.front()));
  checks.push_back(strokes(observations, machine));
  if (std::ranges::any_of(observations.rows, has_place)) checks.push_back(place_units(observations));
  if (std::ranges::count(observations.rows, ReadingKind::contact, &Observation::kind) > 0)
    checks.push_back(rounding_check(observations, machine));
  checks.push_back(reference(observations));
  add(covariates(observations, machine));
  if (!moves_right || checks[1].outcome == Outcome::failed) return checks;
  const bool poses =
      std::ranges::any_of(observations.rows, [](const Observation& o) { return o.kind == ReadingKind::pose; });
  if (poses) {
    checks.push_back(
        {.id = "freedoms",
         .outcome = Outcome::passed,
         .found = "poses see all six freedoms; where the instrument stands is unknown, so that they tell nothing of "
                  "the rotation senses",
         .advice = {}});
    return checks;
  }
  try {
    const LinearProblem problem = make_linear_problem(observations, machine);
    add(freedoms(problem, observations, machine.tilt_letter()));
  } catch (const InputError& e) {
    checks.push_back({.id = "usable",
                      .outcome = Outcome::failed,
                      .found = e.what(),
                      .advice = "identify would refuse these readings"});
  }
  return checks;
}

}  // namespace trunnion
