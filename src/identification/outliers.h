#pragma once

#include <string>
#include <vector>

#include "identification/smooth_fit.h"

namespace trunnion {

/// A reading far from what the smooth map says.
struct Outlier {
  std::size_t reading = 0;  ///< index into LinearProblem::readings
  double residual = 0;      ///< mm or rad
  double normalised = 0;    ///< residual over its own standard deviation
};

/// What the search for outliers found, and the smooth fit without them.
struct OutlierSearch {
  std::vector<Outlier> removed;
  std::vector<Outlier>
      crowded;        ///< far off, but together in one artifact, pose or stretch of time: an effect, not chips; kept
  std::string crowd;  ///< where they crowd, in words; empty if they do not
  std::vector<bool> used;  ///< one per reading
  double noise_scale = 1;  ///< robust standard deviation of the normalised residuals
  SmoothFit fit;
};

constexpr int kReweightings = 6, kSnoopingRounds = 4;
constexpr int kMostOutlierFits = 3 + kReweightings + kSnoopingRounds;

/// When a reading counts as an outlier.
struct OutlierOptions {
  double threshold = 3.9;       ///< of the normalised residual (alpha = 1e-4)
  double most_fraction = 0.05;  ///< of the readings that may be removed
};

/// Finds outliers in the smooth model, where every touch is checked by its neighbours, by iteratively reweighted least
/// squares with Student-t weights (4 degrees of freedom) and then one by one (data snooping). `smooth.progress` is told
/// what share of kMostOutlierFits is done; it may end with fewer.
OutlierSearch find_outliers(const LinearProblem& problem, const HarmonicBasis& basis, const SmoothOptions& smooth,
                            const OutlierOptions& options = {});

}  // namespace trunnion
