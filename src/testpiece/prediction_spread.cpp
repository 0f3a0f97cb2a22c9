#include "testpiece/prediction_spread.h"

#include <algorithm>
#include <cmath>

#include "linear_algebra/factors.h"
#include "model/effects/rotary_error_map.h"
#include "testpiece/parallel.h"
#include "testpiece/profile_filter.h"
#include "units/angle.h"

namespace trunnion {
namespace {

/// splitmix64 from (seed, stream), normal deviates by Box and Muller: the same on every machine, whatever the order in
/// which streams are used.
class NormalStream {
 public:
  NormalStream(std::uint64_t seed, std::uint64_t stream) : state_(mixed(seed + 0x632be59bd9b4e019U) ^ mixed(stream)) {}
  std::uint64_t bits() { return mixed(state_ += 0x9e3779b97f4a7c15U); }
  double uniform() { return (static_cast<double>(bits() >> 11U) + 0.5) * 0x1p-53; }
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2 * std::log(uniform())), angle = kTurn_rad * uniform();
    has_spare_ = true;
    spare_ = radius * std::sin(angle);
    return radius * std::cos(angle);
  }

 private:
  static std::uint64_t mixed(std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31U);
  }
  std::uint64_t state_;
  double spare_ = 0;
  bool has_spare_ = false;
};

/// L with L L^T = covariance, which may be semidefinite.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance) { return PivotedCholesky(covariance).root(); }

DrawnSpread spread_of(std::vector<double> values) {
  double mean = 0, squares = 0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  for (const double v : values) squares += (v - mean) * (v - mean);
  std::ranges::sort(values);
  const auto quantile = [&](double share) {
    const double at = share * static_cast<double>(values.size() - 1);
    const auto i = static_cast<std::size_t>(at);
    const double part = at - static_cast<double>(i);
    return i + 1 < values.size() ? (1 - part) * values[i] + part * values[i + 1] : values[i];
  };
  return {values.size() > 1 ? std::sqrt(squares / static_cast<double>(values.size() - 1)) : 0, quantile(0.025),
          quantile(0.975)};
}

/// Filters a set of deviations, height by height; the filter is linear.
Eigen::VectorXd filtered(const TestPiece& piece, const SurfaceGrid& surface, const Eigen::VectorXd& deviation,
                         double cutoff_upr) {
  Eigen::VectorXd result(deviation.size());
  Eigen::Index at = 0;
  for (const ConeTrace& trace :
       traces_of(piece, surface, {deviation.data(), static_cast<std::size_t>(deviation.size())}))
    for (const double v :
         gaussian_filtered({trace.nominal_radius_mm, trace.phi_rad, trace.normal_mm}, cutoff_upr).radial_mm)
      result[at++] = v;
  return result;
}

}  // namespace

DeviationSpread::DeviationSpread(const TestPiece& piece, const SurfaceGrid& surface, std::span<const ToolPosition> path,
                                 const KinematicChain& chain, const Model& model, const Situation& known)
    : piece_(piece), surface_(surface) {
  const std::vector<CutPoint> points = cut_points(piece, surface.points, path, chain);
  const auto rows = static_cast<Eigen::Index>(points.size());
  columns_.resize(rows, 0);
  for (const EffectPtr& effect : model.effects) {
    if (!effect->is_compensated() || effect->covariance().size() == 0) continue;
    const Eigen::MatrixXd root = root_of(effect->covariance());
    Eigen::MatrixXd part(rows, root.cols());
    for (Eigen::Index i = 0; i < rows; ++i) {
      const CutPoint& at = points[static_cast<std::size_t>(i)];
      part.row(i) = at.by_error.transpose() * effect->basis(situation_at(path[at.position], piece.tool.length, known));
    }
    const Eigen::Index before = columns_.cols();
    columns_.conservativeResize(Eigen::NoChange, before + root.cols());
    columns_.rightCols(root.cols()) = part * root;
  }

  const RotaryErrorMap* map = model.rotary_map();
  if (map == nullptr) return;
  const RotaryMapContent& content = map->content();
  if (content.interpolation_sigma_mm <= 0 && content.interpolation_sigma_rad <= 0) return;
  const auto stations = static_cast<int>(content.grid.c_stations.size());
  for (int harmonic = stations / 2 + 1; harmonic <= std::max(stations, 2); ++harmonic) {
    Eigen::MatrixXd part = Eigen::MatrixXd::Zero(rows, 12);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const CutPoint& at = points[static_cast<std::size_t>(i)];
      const double c = path[at.position].at.c.in_radians();
      Vector6d sized = at.by_error;
      sized.head<3>() *= content.interpolation_sigma_mm;
      sized.tail<3>() *= content.interpolation_sigma_rad;
      part.row(i).head<6>() = std::cos(harmonic * c) * sized;
      part.row(i).tail<6>() = std::sin(harmonic * c) * sized;
    }
    unseen_.push_back(std::move(part));
  }
}

std::vector<double> DeviationSpread::deviation_sd_mm() const {
  Eigen::VectorXd variance = columns_.rowwise().squaredNorm();
  // cos^2 + sin^2 make the same variance at every C, whichever harmonic it is.
  if (!unseen_.empty()) variance += unseen_.front().rowwise().squaredNorm();
  std::vector<double> sd;
  for (const double v : variance) sd.push_back(std::sqrt(v));
  return sd;
}

PredictionSpread DeviationSpread::around(std::span<const double> deviation_mm, const DrawOptions& options) const {
  PredictionSpread result{.deviation_sd_mm = deviation_sd_mm()};
  Eigen::VectorXd center =
      Eigen::Map<const Eigen::VectorXd>(deviation_mm.data(), static_cast<Eigen::Index>(deviation_mm.size()));
  Eigen::MatrixXd columns = columns_;
  std::vector<Eigen::MatrixXd> unseen = unseen_;
  if (options.evaluation.filter_upr) {
    const auto filter = [&](const Eigen::VectorXd& v) {
      return filtered(piece_, surface_, v, *options.evaluation.filter_upr);
    };
    center = filter(center);
    for (Eigen::Index c = 0; c < columns.cols(); ++c) columns.col(c) = filter(columns.col(c));
    for (Eigen::MatrixXd& part : unseen)
      for (Eigen::Index c = 0; c < part.cols(); ++c) part.col(c) = filter(part.col(c));
  }

  const auto draws = static_cast<std::size_t>(std::max(options.draws, 2));
  std::vector<ConeEvaluation> drawn(draws);
  constexpr std::size_t kBatch = 64;  // a matrix product for many draws at once
  std::size_t done = 0;
  std::mutex guard;
  in_blocks((draws + kBatch - 1) / kBatch, options.threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t batch = first; batch < last; ++batch) {
      const std::size_t from = batch * kBatch, to = std::min(from + kBatch, draws);
      Eigen::MatrixXd z(columns.cols(), static_cast<Eigen::Index>(to - from));
      Eigen::MatrixXd deviation = center.replicate(1, z.cols());
      for (std::size_t k = from; k < to; ++k) {
        NormalStream stream(options.seed, k);
        const auto column = static_cast<Eigen::Index>(k - from);
        for (Eigen::Index v = 0; v < z.rows(); ++v) z(v, column) = stream.normal();
        if (unseen.empty()) continue;
        const Eigen::MatrixXd& part = unseen[stream.bits() % unseen.size()];
        Eigen::Matrix<double, 12, 1> twelve;
        for (double& v : twelve) v = stream.normal();
        deviation.col(column) += part * twelve;
      }
      deviation += columns * z;
      for (std::size_t k = from; k < to; ++k) {
        const Eigen::VectorXd one = deviation.col(static_cast<Eigen::Index>(k - from));
        drawn[k] = evaluate_cone(traces_of(piece_, surface_, {one.data(), static_cast<std::size_t>(one.size())}),
                                 piece_.cone.half_angle);
      }
      const std::scoped_lock lock(guard);
      done += to - from;
      if (options.progress) options.progress(static_cast<double>(done) / static_cast<double>(draws));
    }
  });

  const auto over_draws = [&](auto value) {
    std::vector<double> values;
    values.reserve(draws);
    for (const ConeEvaluation& e : drawn) values.push_back(value(e));
    return spread_of(std::move(values));
  };
  for (std::size_t j = 0; j < surface_.h_mm.size(); ++j) {
    const auto at_height = [&](auto value) {
      return over_draws([&](const ConeEvaluation& e) { return value(e.heights[j]); });
    };
    result.heights.push_back({at_height([](const HeightEvaluation& e) { return e.lsc_mm; }),
                              at_height([](const HeightEvaluation& e) { return e.mzc_mm; }),
                              at_height([](const HeightEvaluation& e) { return e.mic_mm; }),
                              at_height([](const HeightEvaluation& e) { return e.mcc_mm; }),
                              at_height([](const HeightEvaluation& e) { return e.diameter_mm; }),
                              at_height([](const HeightEvaluation& e) { return e.center_mm.x(); }),
                              at_height([](const HeightEvaluation& e) { return e.center_mm.y(); })});
  }
  if (drawn.front().half_angle) {
    result.half_angle_rad = over_draws([](const ConeEvaluation& e) { return e.half_angle->in_radians(); });
    result.axis_tilt_rad = over_draws([](const ConeEvaluation& e) { return e.axis_tilt_rad->norm(); });
  }
  result.form_mm = over_draws([](const ConeEvaluation& e) { return e.form_mm; });
  result.rms_mm = over_draws([](const ConeEvaluation& e) { return e.rms_mm; });
  return result;
}

}  // namespace trunnion
