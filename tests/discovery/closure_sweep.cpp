// Closes the loop on many virtual machines and prints what came of each, one JSON object a line:
//   closure_sweep KIND MEASURED FIRST COUNT [NAME]
//   closure_sweep list   the names of effects and inventions
// KIND: effect, two, chips (NAME: an id, or two with a + between), invention (NAME), null, student, harmonics, piece
// (a cone on a machine with an undeclared backlash of C), piece_null (on one that lacks nothing).
// MEASURED: calibration, verified, three_passes, three_passes_verified; of a piece: alone, with_probing, upright.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "discovery/closure_case.h"
#include "discovery/inventions.h"
#include "testpiece/piece_case.h"

namespace {

using namespace trunnion;
using namespace trunnion::testing;

constexpr double kDetectable = 25.6;           // noncentrality that is found in nine of ten cases
constexpr double kFolds = 1.5, kVerified = 2;  // times the amplitude that has it

Measured measured_from(const std::string& name) {
  static const std::map<std::string, Measured> known = {{"calibration", Measured::calibration},
                                                        {"verified", Measured::verified},
                                                        {"three_passes", Measured::three_passes},
                                                        {"three_passes_verified", Measured::three_passes_verified}};
  return known.at(name);
}

const Invention* invention_called(const std::string& name) {
  for (const Invention& i : inventions())
    if (i.name == name) return &i;
  throw std::invalid_argument("no invention is called " + name);
}

nlohmann::json row(const ClosureCase& c, const std::string& kind, const std::string& name) {
  const std::clock_t start = std::clock();
  const ClosureOutcome outcome = close_case(c);
  const ClosureResult& r = outcome.closure;
  nlohmann::json accepted = nlohmann::json::array(), named = nlohmann::json::array(), visible = nlohmann::json::array();
  bool all_found = !c.effects.empty();
  for (const AcceptedEffect& e : r.effects) accepted.push_back(e.effect->id()), visible.push_back(e.visible_fraction);
  for (const std::string& id : c.effects) {
    named.push_back(outcome.found(id));
    all_found = all_found && outcome.found(id);
  }
  return {{"kind", kind},
          {"name", name},
          {"seed", c.seed},
          {"visible", outcome.visible},
          {"accepted", accepted},
          {"named", named},
          {"visible_fraction", visible},
          {"right", all_found && r.effects.size() == c.effects.size()},
          {"verdict", verdict_text(r.verdict)},
          {"residual_um", r.after.rms_um},
          {"chi2", r.after.reduced_chi2},
          {"holdout_before_um", r.before.holdout_rms_um},
          {"holdout_after_um", r.after.holdout_rms_um},
          {"map_before_um", map_error_um(r.bare_model, outcome)},
          {"map_after_um", map_error_um(r.model, outcome)},
          {"outliers", r.outliers.size()},
          {"refused", r.refused},
          {"cpu_s", static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC}};
}

/// A cone that leans more than its half angle, by itself or joined with a probing, or an upright one.
nlohmann::json piece_row(const std::string& kind, const std::string& measured, std::uint64_t seed) {
  constexpr double kUndeclared_rad = 30e-6;
  const std::clock_t start = std::clock();
  const PieceOutcome outcome = close_piece({.seed = seed,
                                            .tilt_deg = measured == "upright" ? 10.0 : 30.0,
                                            .backlash_rad = kind == "piece" ? kUndeclared_rad : 0,
                                            .with_probing = measured == "with_probing"});
  nlohmann::json accepted = nlohmann::json::array();
  for (const AcceptedEffect& e : outcome.closure.effects) accepted.push_back(e.effect->id());
  return {{"kind", kind},
          {"name", ""},
          {"seed", seed},
          {"accepted", accepted},
          {"named", outcome.names_the_backlash()},
          {"untestable", outcome.backlash_is_untestable()},
          {"verdict", verdict_text(outcome.closure.verdict)},
          {"roundness_before_um", outcome.roundness_before_um},
          {"roundness_after_um", outcome.roundness_after_um},
          {"cpu_s", static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC}};
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc == 2 && std::string(argv[1]) == "list") {
    nlohmann::json names = {{"effects", undeclared_ids()}, {"inventions", nlohmann::json::array()}};
    for (const Invention& i : inventions()) names["inventions"].push_back(i.name);
    std::printf("%s\n", names.dump().c_str());
    return 0;
  }
  if (argc < 5) throw std::invalid_argument("closure_sweep KIND MEASURED FIRST COUNT [NAME]");
  const std::string kind = argv[1], name = argc > 5 ? argv[5] : "";
  const std::uint64_t first = std::strtoull(argv[3], nullptr, 10), count = std::strtoull(argv[4], nullptr, 10);
  if (kind == "piece" || kind == "piece_null") {
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
      std::printf("%s\n", piece_row(kind, argv[2], seed).dump().c_str());
      std::fflush(stdout);
    }
    return 0;
  }
  ClosureCase c{.measured = measured_from(argv[2])};
  const bool later = c.measured == Measured::verified || c.measured == Measured::three_passes_verified;
  const double times = later ? kVerified : kFolds;
  if (kind == "effect" || kind == "chips" || kind == "two" || kind == "student") {
    const std::size_t plus = name.find('+');
    if (!name.empty()) c.effects.push_back(name.substr(0, plus));
    if (plus != std::string::npos) c.effects.push_back(name.substr(plus + 1));
    c.noncentrality = kDetectable * times * times;
  }
  if (kind == "chips") c.noise.chip_rate = .02;
  if (kind == "student") c.noise.student_freedom = 5;
  if (kind == "harmonics") c.machine.C_harmonics = 4;
  if (kind == "invention") {
    c.invention = invention_called(name);
    c.noncentrality = 4 * kDetectable * times * times;  // abrupt ones are seen by no more than their smooth part
  }
  for (c.seed = first; c.seed < first + count; ++c.seed) {
    if (kind == "null") c.machine.C_harmonics = 2 + static_cast<int>(c.seed % 3);
    std::printf("%s\n", row(c, kind, name).dump().c_str());
    std::fflush(stdout);
  }
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "closure_sweep: %s\n", e.what());
  return 1;
}
