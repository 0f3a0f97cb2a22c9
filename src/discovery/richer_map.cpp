#include "discovery/richer_map.h"

#include <algorithm>
#include <vector>

#include "discovery/process_gain.h"

namespace trunnion {
namespace {

/// Coefficients of `richer` that `basis` does not have.
std::vector<Eigen::Index> added_coefficients(const HarmonicBasis& basis, const HarmonicBasis& richer) {
  std::vector<Eigen::Index> added;
  const auto add_function = [&](Eigen::Index f) {
    for (Eigen::Index k = 0; k < 6; ++k) added.push_back(6 * f + k);
  };
  for (Eigen::Index f = basis.tilt_functions(); f < richer.tilt_functions(); ++f) add_function(f);
  const Eigen::Index per_wave = richer.turn_degree + 1;
  for (Eigen::Index g = 0; g < richer.turn_functions() - 1; ++g) {
    const Eigen::Index harmonic = 1 + g / (2 * per_wave), degree = g % per_wave;
    if (harmonic > basis.harmonics || degree > basis.turn_degree) add_function(richer.tilt_functions() + 1 + g);
  }
  return added;
}

}  // namespace

RicherMap best_richer_map(const Workbench& bench) {
  const HarmonicBasis& basis = bench.basis();
  HarmonicBasis more_tilt = basis, more_harmonics = basis, more_products = basis;
  if (basis.tilt_degree > 0) more_tilt.tilt_degree += 3;
  if (basis.harmonics > 0) more_harmonics.harmonics += 2, more_products.turn_degree = 4;
  HarmonicBasis all = more_harmonics;
  all.tilt_degree = more_tilt.tilt_degree;
  all.turn_degree = more_products.turn_degree;
  const SmoothDesign design = smooth_design(bench.problem(), all, bench.prior());
  RicherMap best{basis};
  // The columns of each enlargement are among those of the one that holds them all.
  const auto offer = [&](const HarmonicBasis& there) {
    std::vector<Eigen::Index> added = added_coefficients(basis, all);
    const std::vector<Eigen::Index> beyond = added_coefficients(there, all);
    std::erase_if(added, [&](Eigen::Index k) { return std::ranges::find(beyond, k) != beyond.end(); });
    if (added.empty()) return;
    const Eigen::MatrixXd z =
        design.columns(Eigen::all, added) * design.precision(added).cwiseSqrt().cwiseInverse().asDiagonal();
    if (const double gain = best_process_gain(bench.smooth(), z).gain; gain > best.gain) best = {there, gain};
  };
  for (const HarmonicBasis& there : {more_tilt, more_harmonics, more_products, all}) offer(there);
  return best;
}

}  // namespace trunnion
