#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "discovery/candidate.h"
#include "identification/identify.h"

namespace trunnion {

/// What the search for missing effects may do.
struct ClosureOptions {
  double level = 0.01;          ///< family-wise, over all columns scanned
  double flip_level = 0.03;     ///< family-wise, where whole poses change their signs
  double smooth_level = 0.001;  ///< chi-square below which the smooth fallback opens
  int most_effects = 4;
  int folds = 5;  ///< of poses, where there is no verification
  std::size_t most_readings =
      8000;  ///< of a longer log, one reading of each run of so many is searched, drawn at random
  std::function<void(const std::string& step)> progress = {};  ///< told what is being done, for people
};

/// What the residuals say of the model, before and after the search (CONTRACT: Closure).
enum class Verdict { nothing_missing, explained, partly_explained, unexplained };
std::string_view verdict_text(Verdict verdict);

/// Root mean squares and chi-square of one stage; lengths um (rotations at a lever of 100 mm).
struct ClosureStage {
  double rms_um = 0;
  double reduced_chi2 = 0;
  double chi2_p = 1;
  double holdout_rms_um = 0;  ///< over hold-out poses alone (HoldoutError::rms_um), or poses left out in turn
  double holdout_plain_rms_um = 0;
};

/// A catalogue effect that does nearly what an accepted one does.
struct Alternative {
  std::string id;
  Origin origin = Origin::machine;
  double correlation = 0;     ///< share of the fitted effect that it can take over, outside the base
  double log_likelihood = 0;  ///< by which it is behind the accepted one, each at its price
};

/// One accepted effect with its evidence.
struct AcceptedEffect {
  EffectPtr effect;       ///< with final values and covariance
  bool smooth = false;    ///< found by the fallback, not named by the catalogue
  double largest_um = 0;  ///< of what it does to a reading (rotations at 100 mm)
  double p_value = 1;     ///< family-wise
  double visible_fraction = 0;
  bool rigid_within_poses = false;  ///< only the smooth base shows it: this effect, or a more complex map
  double rms_before_um = 0, rms_after_um = 0, holdout_before_um = 0, holdout_after_um = 0;
  std::vector<Alternative> alternatives;        ///< the likeliest first
  std::vector<std::string> not_separable_from;  ///< those that do the same, or are as likely
  std::vector<std::string> partly_separable_from;
  std::vector<std::string> needs;  ///< covariates that a correction has to be told: time, temperature, extra columns
  std::string separate_by;
  bool absurd = false;  ///< a magnitude that no sound machine has
};

/// An effect that these data cannot test, and what would.
struct Untestable {
  std::string id;
  std::string separate_by;
};

/// What the search for missing effects found.
struct ClosureResult {
  Verdict verdict = Verdict::nothing_missing;
  double noise_um = 0;  ///< declared sigma
  ClosureStage before, after;
  bool has_holdout = false;
  std::vector<AcceptedEffect> effects;
  std::vector<std::string> refused;  ///< what was tried and failed a gate, in words
  std::vector<Untestable> untestable;
  Model model;       ///< the extended model: map, effects of the machine and of the measurement
  Model bare_model;  ///< the same data's map without them
  std::size_t columns_scanned = 0;
  std::vector<std::size_t> outliers;                    ///< readings left out
  LinearProblem problem;                                ///< all readings searched, calibration first
  std::shared_ptr<const ObservationSet> thinned;        ///< what is searched of a long log; else empty
  std::vector<double> residual_before, residual_after;  ///< per reading, mm or rad
  std::vector<bool> holdout;                            ///< per reading
};

/// Looks for effects that the data show and the model lacks. `all` holds the calibration and then, from row
/// `verification_from` on, the verification (all.rows.size() where there is none); it must outlive the result.
ClosureResult close_loop(const ObservationSet& all, std::size_t verification_from, const Machine& machine,
                         const ClosureOptions& options = {});

}  // namespace trunnion
