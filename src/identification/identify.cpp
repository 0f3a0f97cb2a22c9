#include "identification/identify.h"

#include <algorithm>
#include <cmath>

#include "error.h"
#include "identification/distributions.h"
#include "identification/findings.h"
#include "identification/map_grid.h"

namespace trunnion {
namespace {

constexpr double kLever_mm = 100;
constexpr double kDegree_rad = Angle::degrees(1).in_radians();

Situation at_position(IndexedPosition at) {
  Situation s;
  s.at = at;
  return s;
}

/// Adds up how far predictions are off, as displacements, angle by angle.
class Score {
 public:
  void begin(LeftOutAngle::Of of, Angle angle = {}) { angles_.push_back({.of = of, .angle = angle}); }
  void add(const Vector6d& error) {
    um2_ += error.head<3>().squaredNorm() * 1e6;
    urad2_ += error.tail<3>().squaredNorm() * 1e12;
    angles_.back().score_um +=
        (error.head<3>().squaredNorm() + kLever_mm * kLever_mm * error.tail<3>().squaredNorm()) * 1e6;
    ++angles_.back().poses;
  }
  InterpolationEvidence evidence(const std::string& method) const {
    InterpolationEvidence found{.method = method};
    double score2 = 0;
    for (LeftOutAngle angle : angles_) {
      if (angle.poses == 0) continue;
      score2 += angle.score_um;
      found.poses += angle.poses;
      angle.score_um = std::sqrt(angle.score_um / static_cast<double>(angle.poses));
      found.angles.push_back(angle);
    }
    const double n = std::max<double>(1, static_cast<double>(found.poses));
    found.rms_um = std::sqrt(um2_ / n);
    found.rms_urad = std::sqrt(urad2_ / n);
    found.score_um = std::sqrt(score2 / n);
    return found;
  }

 private:
  double um2_ = 0, urad2_ = 0;
  std::vector<LeftOutAngle> angles_;  ///< score_um: the sum of squares so far
};

/// The groups of poses that are left out together: whole C columns, interior A rows, and the check poses.
struct Fold {
  std::vector<std::size_t> poses;
  LeftOutAngle::Of of = LeftOutAngle::Of::turn;
  Angle angle;
};
std::vector<Fold> folds_of(const LinearProblem& problem, const PoseGrid& grid) {
  std::vector<Fold> folds;
  const std::size_t columns = grid.c_stations.size();
  const auto collect = [&](LeftOutAngle::Of of, Angle angle, auto belongs) {
    Fold fold{.poses = {}, .of = of, .angle = angle};
    for (std::size_t k = 0; k < grid.pose_at.size(); ++k)
      if (grid.pose_at[k] >= 0 && belongs(k / columns, k % columns) &&
          !problem.poses[static_cast<std::size_t>(grid.pose_at[k])].reference)
        fold.poses.push_back(static_cast<std::size_t>(grid.pose_at[k]));
    if (!fold.poses.empty()) folds.push_back(std::move(fold));
  };
  if (columns >= 3)
    for (std::size_t j = 0; j < columns; ++j)
      collect(LeftOutAngle::Of::turn, grid.c_stations[j], [j](std::size_t, std::size_t column) { return column == j; });
  for (std::size_t i = 1; i + 1 < grid.a_stations.size(); ++i)
    collect(LeftOutAngle::Of::tilt, grid.a_stations[i], [i](std::size_t row, std::size_t) { return row == i; });
  if (!grid.off_grid.empty())
    folds.push_back({.poses = grid.off_grid, .of = LeftOutAngle::Of::check_poses, .angle = {}});
  return folds;
}

ErrorGrid without(const ErrorGrid& grid, std::optional<std::size_t> row, std::optional<std::size_t> column) {
  std::vector<Angle> a = grid.a_stations, c = grid.c_stations;
  if (row) a.erase(a.begin() + static_cast<std::ptrdiff_t>(*row));
  if (column) c.erase(c.begin() + static_cast<std::ptrdiff_t>(*column));
  ErrorGrid result = zero_grid(a, c);
  std::size_t r = 0;
  for (std::size_t i = 0; i < grid.a_stations.size(); ++i) {
    if (row && *row == i) continue;
    result.tilt[r] = grid.tilt[i];
    std::size_t k = 0;
    for (std::size_t j = 0; j < grid.c_stations.size(); ++j)
      if (!(column && *column == j)) result.turn[r * c.size() + k++] = grid.turn[i * grid.c_stations.size() + j];
    ++r;
  }
  return result;
}

/// Prediction of left-out positions by an interpolant of the nodes.
InterpolationEvidence node_evidence(Interpolation method, const LinearProblem& problem, const PoseGrid& grid,
                                    const ErrorGrid& values, const FreePoseFit& fit) {
  Score score;
  const KinematicChain& chain = *problem.chain;
  const auto predict = [&](const ErrorSurface& surface, const ErrorSurface& whole, IndexedPosition at) {
    return relative_pose_error(chain, at, surface.at(at), whole.at({}), {}).vector();
  };
  const std::unique_ptr<ErrorSurface> whole = make_surface(method, values);
  const std::size_t columns = grid.c_stations.size();
  const auto leave = [&](std::optional<std::size_t> row, std::optional<std::size_t> column) {
    const std::unique_ptr<ErrorSurface> surface = make_surface(method, without(values, row, column));
    if (row) score.begin(LeftOutAngle::Of::tilt, grid.a_stations[*row]);
    if (column) score.begin(LeftOutAngle::Of::turn, grid.c_stations[*column]);
    for (std::size_t k = 0; k < grid.pose_at.size(); ++k) {
      if ((row && k / columns != *row) || (column && k % columns != *column) || grid.pose_at[k] < 0) continue;
      const auto p = static_cast<std::size_t>(grid.pose_at[k]);
      if (problem.poses[p].reference) continue;
      const IndexedPosition at{grid.a_stations[k / columns], grid.c_stations[k % columns]};
      score.add(predict(*surface, *whole, at) - fit.delta[p].vector());
    }
  };
  if (columns >= 3)
    for (std::size_t j = 0; j < columns; ++j) leave({}, j);
  for (std::size_t i = 1; i + 1 < grid.a_stations.size(); ++i) leave(i, {});
  score.begin(LeftOutAngle::Of::check_poses);
  for (const std::size_t p : grid.off_grid)
    if (whole->covers(problem.poses[p].at.a) && !problem.poses[p].reference)
      score.add(predict(*whole, *whole, problem.poses[p].at) - fit.delta[p].vector());
  return score.evidence(std::string(interpolation_name(method)));
}

InterpolationEvidence smooth_evidence(const LinearProblem& problem, const PoseGrid& grid, const FreePoseFit& fit,
                                      const SmoothFit& smooth, const std::vector<bool>& used,
                                      const std::function<void(double)>& progress) {
  Score score;
  const std::vector<Fold> folds = folds_of(problem, grid);
  int fits = 0;
  for (const Fold& fold : folds) {
    std::vector<bool> left_out(problem.poses.size(), false);
    for (const std::size_t p : fold.poses) left_out[p] = true;
    SmoothOptions options{.prior = smooth.prior};
    if (progress)
      options.progress = [&](double share) { progress((fits + share) / static_cast<double>(folds.size())); };
    for (std::size_t i = 0; i < problem.readings.size(); ++i)
      options.weights.push_back(left_out[problem.readings[i].pose] || !used[i] ? 0.0 : 1.0);
    const SmoothFit partial = fit_smooth(problem, smooth.basis, options);
    ++fits;
    score.begin(fold.of, fold.angle);
    for (const std::size_t p : fold.poses)
      if (!problem.poses[p].reference)
        score.add(gauged_basis(*problem.chain, smooth.basis, at_position(problem.poses[p].at)) * partial.coefficients -
                  fit.delta[p].vector());
  }
  return score.evidence("gaussian-process");
}

/// What an interpolant of the nodes misses between them, if the truth is what the smooth fit says and is spread about
/// as its posterior: root mean square over positions halfway.
void set_interpolation_sigma(RotaryMapContent& content, const LinearProblem& problem, const SmoothFit& smooth,
                             const PoseGrid& grid) {
  const std::unique_ptr<ErrorSurface> nodes = make_surface(content.interpolation, content.grid);
  double length2 = 0, angle2 = 0, count = 0;
  for (std::size_t i = 0; i + 1 < std::max<std::size_t>(2, grid.a_stations.size()); ++i)
    for (std::size_t j = 0; j < grid.c_stations.size(); ++j) {
      const Angle a =
          grid.a_stations.size() > 1 ? 0.5 * (grid.a_stations[i] + grid.a_stations[i + 1]) : grid.a_stations[0];
      const Angle next = j + 1 < grid.c_stations.size() ? grid.c_stations[j + 1] : grid.c_stations[0] + kFullTurn;
      const IndexedPosition at{a, 0.5 * (grid.c_stations[j] + next)};
      const Vector6d here = relative_pose_error(*problem.chain, at, nodes->at(at), nodes->at({}), {}).vector();
      const Matrix6Xd b = gauged_basis(*problem.chain, smooth.basis, at_position(at));
      const Vector6d gap = here - b * smooth.coefficients;
      const Vector6d spread = (b * smooth.covariance * b.transpose()).diagonal();
      length2 += (gap.head<3>().squaredNorm() + spread.head<3>().sum()) / 3;
      angle2 += (gap.tail<3>().squaredNorm() + spread.tail<3>().sum()) / 3;
      ++count;
    }
  content.interpolation_sigma_mm = std::sqrt(length2 / count);
  content.interpolation_sigma_rad = std::sqrt(angle2 / count);
}

/// Each sigma times the noise of its kind.
double rms_sigma_um(const LinearProblem& problem, double length_noise = 1, double angle_noise = 1) {
  double sum = 0;
  for (const Reading& reading : problem.readings)
    sum += std::pow(reading.sigma * (reading.angular ? angle_noise * kLever_mm : length_noise), 2);
  return 1e3 * std::sqrt(sum / static_cast<double>(problem.readings.size()));
}

/// The stations of `grid` and of an earlier map, none twice.
PoseGrid with_stations_of(PoseGrid grid, const ErrorGrid& earlier) {
  constexpr double kSame_rad = 0.1 * kDegree_rad;
  const auto merge = [&](std::vector<Angle>& stations, const std::vector<Angle>& more, double period) {
    for (const Angle angle : more) {
      const auto same = [&](Angle station) {
        const double gap = (angle - station).in_radians();
        return std::abs(period > 0 ? std::remainder(gap, period) : gap) < kSame_rad;
      };
      if (std::ranges::none_of(stations, same)) stations.push_back(angle);
    }
    std::ranges::sort(stations);
  };
  merge(grid.a_stations, earlier.a_stations, 0);
  merge(grid.c_stations, earlier.c_stations, kFullTurn.in_radians());
  grid.pose_at.assign(grid.a_stations.size() * grid.c_stations.size(), -1);
  return grid;
}

/// Location errors in a map that is told by its smooth surface.
LocationFinding locations_of_surface(const LinearProblem& problem, const PoseGrid& grid, const SmoothFit& smooth,
                                     const Machine& machine) {
  std::vector<IndexedPosition> at;
  for (const Angle a : grid.a_stations)
    for (const Angle c : grid.c_stations) at.push_back({a, c});
  Eigen::MatrixXd basis(6 * static_cast<Eigen::Index>(at.size()), smooth.coefficients.size());
  for (std::size_t k = 0; k < at.size(); ++k)
    basis.middleRows<6>(6 * static_cast<Eigen::Index>(k)) =
        gauged_basis(*problem.chain, smooth.basis, at_position(at[k]));
  return find_locations(at, basis * smooth.coefficients, basis * smooth.covariance * basis.transpose(), machine);
}

/// What the belief adds to chi-square, against what free poses leave.
BeliefFinding judged(const SmoothFit& smooth, const LinearProblem& problem, const FreePoseFit* fit, double misfit) {
  BeliefFinding finding{.chi_square = smooth.weighted_rss + smooth.belief_misfit,
                        .freedom = static_cast<double>(smooth.readings) - static_cast<double>(problem.unknowns.size()),
                        .misfit = misfit};
  if (fit != nullptr) {
    finding.chi_square -= fit->weighted_rss;
    finding.freedom -= static_cast<double>(fit->degrees_of_freedom());
  }
  finding.chi_square = std::max(0.0, finding.chi_square);
  finding.p_value = chi_square_tail(finding.chi_square, finding.freedom);
  return finding;
}

}  // namespace

IdentificationResult identify(const ObservationSet& observations, const Machine& machine,
                              const IdentificationOptions& options) {
  IdentificationResult result{.method = options.method, .problem = make_linear_problem(observations, machine)};
  const LinearProblem& problem = result.problem;
  const EffectContext context = effect_context(machine);
  result.model.machine = {machine.name, machine.serial, machine.structure.code};
  HarmonicBasis basis = basis_for(problem);
  const bool two_step = options.method == IdentificationMethod::two_step;
  if (two_step && problem.has_pose_kind)
    throw InputError(observations.files.front(), "the two-step method knows contact readings only; use --method joint");
  const bool free_poses = !problem.has_pose_kind && !problem.chain->has_rotary(Side::tool);

  SmoothOptions smooth_options{.free_noise = !problem.sigma_declared};
  double misfit = 1;
  if (options.earlier) {
    if (two_step) throw UsageError("the two-step method takes no earlier map; use --method joint");
    smooth_options.prior = fit_smooth(problem, basis, smooth_options).prior;
    CarriedMap carried =
        carried_over(*options.earlier->map, problem, basis, *smooth_options.prior, options.earlier->drift);
    basis = carried.basis;
    misfit = carried.misfit;
    smooth_options.belief = std::move(carried.belief);
  }
  // The work is in fits of the smooth map, in the search for outliers and then with each angle left out.
  std::function<void(double)> judging;
  if (options.progress) {
    const auto folds = static_cast<double>(folds_of(problem, find_grid(problem.poses)).size());
    const double search = kMostOutlierFits / (kMostOutlierFits + folds);
    smooth_options.progress = [&options, search](double share) { options.progress(search * share); };
    judging = [&options, search](double share) { options.progress(search + (1 - search) * share); };
  }
  std::vector<bool> used(problem.readings.size(), true);
  if (options.robust && !two_step) {
    OutlierSearch search = find_outliers(problem, basis, smooth_options);
    result.outliers = std::move(search.removed);
    result.crowded = std::move(search.crowded);
    result.crowd = std::move(search.crowd);
    used = std::move(search.used);
    result.smooth = std::move(search.fit);
  } else {
    result.smooth = fit_smooth(problem, basis, smooth_options);
  }

  PoseGrid grid = find_grid(problem.poses);
  if (options.earlier) grid = with_stations_of(std::move(grid), options.earlier->map->content().grid);
  RotaryMapContent content;
  std::optional<FreePoseFit> fit;
  double rss = result.smooth.weighted_rss;
  result.readings = result.smooth.readings;
  result.unknowns = static_cast<std::size_t>(basis.coefficient_count()) + problem.unknowns.size();
  result.rank = result.unknowns;
  result.freedom = static_cast<double>(result.readings) - result.smooth.effective_parameters;
  std::vector<double> redundancy = result.smooth.redundancy;
  if (free_poses) {
    fit = two_step ? fit_two_step(problem) : fit_free_poses(problem, used);
    rss = fit->weighted_rss;
    result.readings = fit->readings;
    result.unknowns = fit->unknown_count;
    result.rank = fit->rank;
    result.condition = fit->condition;
    result.freedom = static_cast<double>(fit->degrees_of_freedom());
    result.unseen = fit->unseen;
    result.undetermined = fit->undetermined_unknowns;
    redundancy = fit->redundancy;
  }
  if (options.earlier) {
    result.belief = judged(result.smooth, problem, fit ? &*fit : nullptr, misfit);
    redundancy = result.smooth.redundancy;  // the earlier map checks what other readings do not
    result.unseen.clear();
    result.undetermined.clear();
  }
  for (std::size_t i = 0; i < redundancy.size(); ++i) {
    if (!used[i]) continue;
    result.worst_redundancy = std::min(result.worst_redundancy, redundancy[i]);
    if (redundancy[i] < 1e-6) result.unchecked.push_back(i);
  }
  result.sigma_declared_um = rms_sigma_um(problem);
  result.reduced_chi_square = result.freedom > 0 ? rss / result.freedom : 1;
  // Free poses are weighed with the sigmas as they stand, the smooth map with what it found of them.
  result.sigma_from_readings = smooth_options.free_noise && !fit;
  const SmoothPrior& found = result.smooth.prior;
  result.sigma_found_um = std::sqrt(result.reduced_chi_square) *
                          (fit ? rms_sigma_um(problem) : rms_sigma_um(problem, found.length_noise, found.angle_noise));
  result.chi_square_p = chi_square_tail(rss, result.freedom);
  if (free_poses && result.chi_square_p < 1e-3) result.uncertainty_scale = std::sqrt(result.reduced_chi_square);
  const double scale2 = result.uncertainty_scale * result.uncertainty_scale;
  result.smooth.covariance *= scale2;
  if (fit) fit->covariance *= scale2;

  if (options.earlier) {
    content = map_from_surface(problem, grid, result.smooth);
    result.location = locations_of_surface(problem, grid, result.smooth, machine);
    fit.reset();  // what the readings say alone has been counted
  } else if (fit) {
    content = map_from_poses(problem, grid, *fit, result.smooth);
    for (std::size_t k = 0; k < grid.pose_at.size(); ++k)
      if (grid.pose_at[k] < 0)
        result.interpolated_nodes.push_back(
            {grid.a_stations[k / grid.c_stations.size()], grid.c_stations[k % grid.c_stations.size()]});
    std::vector<IndexedPosition> probed;
    Eigen::VectorXd delta(fit->covariance.rows());
    for (std::size_t p = 0; p < problem.poses.size(); ++p) {
      if (fit->column[p] < 0) continue;
      delta.segment<6>(fit->column[p]) = fit->delta[p].vector();
      probed.push_back(problem.poses[p].at);
    }
    result.location = find_locations(probed, delta, fit->covariance, machine);
  } else {
    content = map_from_surface(problem, grid, result.smooth);
  }

  // Between the nodes: what predicts best what was left out.
  const bool full_grid = fit && grid.missing() == 0 && fit->unseen.empty();
  if (full_grid && grid.a_stations.size() > 1 && grid.c_stations.size() > 2) {
    for (const Interpolation method : {Interpolation::trig_cubic, Interpolation::bilinear})
      result.interpolation.push_back(node_evidence(method, problem, grid, content.grid, *fit));
    if (!two_step) result.interpolation.push_back(smooth_evidence(problem, grid, *fit, result.smooth, used, judging));
  }
  if (options.earlier && !options.interpolation.empty() && options.interpolation != "gaussian-process")
    throw UsageError("--interpolation: with an earlier map the result is smooth, gaussian-process is wanted");
  result.chosen_interpolation = options.interpolation;
  if (result.chosen_interpolation.empty()) {
    if (two_step) {
      result.chosen_interpolation = "bilinear";  // as the paper's control does
    } else if (result.interpolation.empty()) {
      result.chosen_interpolation = "gaussian-process";
    } else {
      result.chosen_interpolation =
          std::ranges::min_element(result.interpolation, {}, &InterpolationEvidence::score_um)->method;
    }
  }
  const bool unseen = fit && !fit->unseen.empty();
  if (result.chosen_interpolation == "gaussian-process") {
    set_smooth_surface(content, problem, result.smooth);
  } else if (const auto method = interpolation_from_name(result.chosen_interpolation)) {
    content.interpolation = *method;
    set_interpolation_sigma(content, problem, result.smooth, grid);
    if (unseen && options.fill) set_smooth_surface(content, problem, result.smooth);
  } else {
    throw UsageError("--interpolation: \"" + result.chosen_interpolation +
                     "\" found, one of gaussian-process, trig-cubic, bilinear, natural-neighbour is wanted");
  }
  content.filled = unseen && options.fill;
  result.errors = summarise(content, machine.tilt_letter());
  result.model.effects.push_back(std::make_shared<RotaryErrorMap>(std::move(content), context));
  return result;
}

}  // namespace trunnion
