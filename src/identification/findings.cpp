#include "identification/findings.h"

#include <cmath>

#include "geometric_errors/symbol.h"
#include "identification/distributions.h"
#include "identification/whitening.h"
#include "model/effects/location_errors.h"

namespace trunnion {
namespace {

constexpr double kExact = 1e-10;  ///< mm or rad: no instrument is that good

}  // namespace

LocationFinding find_locations(std::span<const IndexedPosition> at, const Eigen::VectorXd& delta,
                               const Eigen::MatrixXd& covariance, const Machine& machine) {
  LocationFinding finding;
  const EffectPtr effect = make_location_errors(effect_context(machine));
  const auto count = static_cast<Eigen::Index>(effect->parameters().size());
  Eigen::MatrixXd design(delta.size(), count);
  for (std::size_t k = 0; k < at.size(); ++k) {
    Situation s;
    s.at = at[k];
    design.middleRows<6>(6 * static_cast<Eigen::Index>(k)) = effect->basis(s);
  }
  Eigen::VectorXd unit(count);
  for (Eigen::Index k = 0; k < count; ++k)
    unit[k] = from_unit(1, effect->parameters()[static_cast<std::size_t>(k)].unit);
  const Eigen::MatrixXd gain = least_squares_gain(design, covariance, unit);
  if (gain.rows() == 0) return finding;
  for (const Parameter& p : effect->parameters()) finding.symbols.push_back(p.name), finding.units.push_back(p.unit);
  finding.values = gain * delta;
  finding.covariance = gain * covariance * gain.transpose();
  const Eigen::VectorXd left = whitening(covariance) * (delta - design * finding.values);
  finding.chi_square = left.squaredNorm();
  finding.freedom = static_cast<double>(left.size() - count);
  finding.p_value = chi_square_tail(finding.chi_square, finding.freedom);
  return finding;
}

std::vector<ErrorFinding> summarise(const RotaryMapContent& content, char tilt_letter) {
  std::vector<ErrorFinding> findings;
  const Eigen::VectorXd values = content.grid.coefficients();
  for (const bool turn : {false, true})
    for (std::size_t c = 0; c < 6; ++c) {
      ErrorFinding f{.symbol = error_symbol(c, turn ? 'C' : tilt_letter), .unit = component_unit(c)};
      std::vector<Eigen::Index> rows;
      std::vector<IndexedPosition> places;
      for (std::size_t i = 0; i < content.grid.a_stations.size(); ++i)
        for (std::size_t j = 0; j < (turn ? content.grid.c_stations.size() : 1); ++j) {
          const std::size_t k = (turn ? content.grid.turn_offset(i, j) : content.grid.tilt_offset(i)) + c;
          ++f.nodes;
          if (!content.unseen.empty() && content.unseen[k]) {
            ++f.unseen;
            continue;
          }
          rows.push_back(static_cast<Eigen::Index>(k));
          places.push_back({content.grid.a_stations[i], turn ? content.grid.c_stations[j] : Angle()});
        }
      Eigen::MatrixXd covariance;
      if (!rows.empty()) covariance = content.grid_covariance(rows, rows);
      // Nodes that are exact are the reference, zero by definition: no reading told them.
      const bool exact = !rows.empty() && covariance.diagonal().maxCoeff() < kExact * kExact;
      if (exact) f.unseen = f.nodes;
      if (!rows.empty() && !exact) {
        const Eigen::VectorXd v = values(rows);
        Eigen::Index largest = 0;
        v.cwiseAbs().maxCoeff(&largest);
        f.largest = v[largest];
        f.largest_std = std::sqrt(std::max(0.0, covariance(largest, largest)));
        f.largest_at = places[static_cast<std::size_t>(largest)];
        f.rms_std = std::sqrt(std::max(0.0, covariance.diagonal().mean()));
        const Eigen::VectorXd white = whitening(covariance) * v;
        f.p_value = chi_square_tail(white.squaredNorm(), static_cast<double>(white.size()));
        f.told_from_zero = f.p_value < 0.01;
      }
      findings.push_back(std::move(f));
    }
  return findings;
}

}  // namespace trunnion
