#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/effect.h"

namespace trunnion {

/// What is needed to make or read an effect.
struct EffectContext {
  std::shared_ptr<const KinematicChain> chain;
  char tilt_letter = 'A';
  Structure structure;  ///< which linear axis stands on which side
};

/// The data that candidates are proposed for: every reading as a situation, in the order taken.
struct CandidateScope {
  EffectContext context;
  std::span<const Situation> readings;
  std::vector<std::string> columns;  ///< covariates that the data carry: time_s, temperature_C, A_dir, extra columns …
  std::vector<std::string> artifacts;  ///< labels
};

/// A family of the catalogue: one way in which a machine or a measurement goes wrong.
struct Family {
  std::string_view name;    ///< as in effect ids
  std::string_view what;    ///< one line for people
  std::string_view remedy;  ///< the measurement that would test it where the data at hand cannot
  double absurd = 0;        ///< a parameter beyond this (inside units) is flagged as not credible; 0: no bound
  /// The candidates worth trying on these data, parameters zero. Scanned shapes give one candidate a value.
  std::function<std::vector<EffectPtr>(const CandidateScope&)> candidates;
  /// Reads back what to_json wrote; `detail` is what follows the colon in the id. Throws ModelError.
  std::function<EffectPtr(const std::string& detail, const nlohmann::json&, const EffectContext&)> read;
};

/// All families, in a fixed order. Adding one: a file in effects/ and a line in catalogue.cpp.
const std::vector<Family>& catalogue();

/// The family of an id `family` or `family:detail`. Throws ModelError for one that the catalogue does not have, naming
/// the nearest.
const Family& family_of(const std::string& id);

/// Reads one entry of a model's "effects". Throws ModelError naming effect and key.
EffectPtr read_effect(const nlohmann::json& json, const EffectContext& context);

}  // namespace trunnion
