#include "conventions/model_checks.h"

#include <algorithm>
#include <cmath>

#include "error.h"
#include "identification/linear_problem.h"
#include "linear_algebra/factors.h"
#include "model/effects/rotary_error_map.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr double kTold = 3;     // standard uncertainties
constexpr double kAbout = 0.3;  // of the whole: what a map between two measurements may differ by
constexpr double kRadius_mm = 100;

std::string joined_words(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

Check size_against_limits(const Model& model, const Machine& machine, const Range<Angle>& tilts) {
  double largest = 0;
  IndexedPosition where;
  for (int i = 0; i <= 12; ++i)
    for (int j = 0; j < 24; ++j) {
      const IndexedPosition at{tilts.low + i / 12.0 * (tilts.high - tilts.low), Angle::degrees(15.0 * j)};
      for (Eigen::Index k = 0; k < 3; ++k) {
        double d = 0;
        try {
          d = deviation_mm(model, {.at = at, .point_r_mm = kRadius_mm * Eigen::Vector3d::Unit(k)}).norm();
        } catch (const RangeError&) {
          continue;  // what no measurement determines is told elsewhere
        }
        if (d > largest) largest = d, where = at;
      }
    }
  Check check{.id = "model.limits", .outcome = Outcome::passed, .found = {}, .advice = {}};
  check.found = "the largest deviation 100 mm from R's origin is " + formatted("%.2f", 1e3 * largest) + " um" +
                ", at " + machine.tilt_letter() + formatted(" %.4g", where.a.in_degrees()) +
                formatted(" C %.4g", where.c.in_degrees()) +
                formatted("; limits.correction_um is %.6g", machine.limits.deviation.in_micrometres());
  if (largest > machine.limits.deviation.in_millimetres()) {
    check.outcome = Outcome::failed;
    check.advice = "correct refuses it: a mistake in the readings or in a unit is likelier than such a machine";
  }
  return check;
}

}  // namespace

Checks model_checks(const Model& model, const Machine& machine) {
  Checks checks;
  const RotaryErrorMap* map = model.rotary_map();
  if (map != nullptr) checks.push_back(size_against_limits(model, machine, map->surface().a_range()));
  const double left = deviation_mm(model, {.point_r_mm = {kRadius_mm, kRadius_mm, kRadius_mm}}).norm();
  checks.push_back(
      {.id = "model.reference",
       .outcome = left < 1e-6 ? Outcome::passed : Outcome::warning,
       .found = "at the reference pose the model leaves " + formatted("%.2g", 1e3 * left) + " um",
       .advice = left < 1e-6 ? "" : "the part is set up there: what is wrong there already is in the set-up"});
  const std::vector<std::string> needs = needed_covariates(model);
  checks.push_back(
      {.id = "model.covariates",
       .outcome = needs.empty() ? Outcome::passed : Outcome::open,
       .found = needs.empty() ? "the model needs nothing but the positions of the axes"
                              : "the model depends on " + joined_words(needs),
       .advice = needs.empty() ? "" : "a job tells them under [covariates]; else these effects stand at their zero"});
  return checks;
}

SignOfErrors sign_of_errors(const ObservationSet& observations, const Model& model, const Machine& machine) {
  const LinearProblem problem = make_linear_problem(observations, machine);
  if (problem.has_pose_kind)
    throw InputError(observations.files.front(), "poses tell the sign of errors by identify alone");
  SignOfErrors result;
  std::vector<std::pair<std::size_t, double>> used;
  for (std::size_t i = 0; i < problem.readings.size(); ++i) {
    const Reading& r = problem.readings[i];
    try {
      used.emplace_back(i, r.functional.dot(relative_error(model, problem.situations[r.row]).vector()) / r.sigma);
    } catch (const RangeError&) {
      ++result.beyond;
    }
  }
  const auto n = static_cast<Eigen::Index>(used.size()), m = static_cast<Eigen::Index>(problem.unknowns.size());
  result.readings = used.size();
  Eigen::MatrixXd zeros = Eigen::MatrixXd::Zero(n, m);
  Eigen::VectorXd value(n), predicted(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Reading& r = problem.readings[used[static_cast<std::size_t>(k)].first];
    value[k] = r.value / r.sigma;
    predicted[k] = used[static_cast<std::size_t>(k)].second;
    for (const auto& [unknown, coefficient] : problem.terms_of(r)) zeros(k, unknown) = coefficient / r.sigma;
  }
  const LeastSquares of_zeros(zeros);
  const auto without = [&](const Eigen::VectorXd& v) { return Eigen::VectorXd(v - zeros * of_zeros.solve(v)); };
  const Eigen::VectorXd x = without(predicted), y = without(value);
  const double square = x.squaredNorm();
  if (square < 1e-9 * std::max(1.0, predicted.squaredNorm())) {
    result.std = std::numeric_limits<double>::infinity();
    return result;
  }
  result.k = x.dot(y) / square;
  const auto freedom = static_cast<double>(n - of_zeros.rank() - 1);
  const double scale = freedom > 0 ? std::max(1.0, (y - result.k * x).squaredNorm() / freedom) : 1;
  result.std = std::sqrt(scale / square);
  return result;
}

Check sign_check(const ObservationSet& observations, const Model& model, const Machine& machine) {
  const SignOfErrors s = sign_of_errors(observations, model, machine);
  Check check{.id = "model.sign", .outcome = Outcome::passed, .found = {}, .advice = {}};
  if (!(s.std < 1)) {
    check.outcome = Outcome::open;
    check.found = "these readings do not tell the sign of the model";
    check.advice = "touch a spot at the reference pose and where the model is largest (-o DIR names one)";
    return check;
  }
  check.found = "the model is in the readings " + with_uncertainty(s.k, s.std) + " times (" +
                std::to_string(s.readings) + " readings" +
                (s.beyond > 0 ? ", " + std::to_string(s.beyond) + " beyond the probed range" : "") + ")";
  if (s.k + kTold * s.std < 0) {
    check.outcome = Outcome::failed;
    check.advice = "its sign is reversed: a correction would double the errors; look for a mirrored axis or -n for n";
  } else if (std::abs(s.k - 1) > std::max(kAbout, kTold * s.std)) {
    check.outcome = Outcome::warning;
    check.advice = "1 is wanted: were these readings taken under a compensation, or has the machine moved?";
  } else if (s.k - kTold * s.std <= 0) {
    check.outcome = Outcome::open;
    check.advice = "too few touches to be sure: touch more, or where the model is larger";
  }
  return check;
}

}  // namespace trunnion
