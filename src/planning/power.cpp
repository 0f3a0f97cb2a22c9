#include "planning/power.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "discovery/candidate.h"
#include "error.h"
#include "linear_algebra/factors.h"
#include "model/model.h"

namespace trunnion {
namespace {

constexpr double kDetectable = 25.6;  // noncentrality found nine times in ten among some two hundred candidates
constexpr double kUnseen = 1e-6;      // of a column's square norm: less than that is rounding
constexpr int kTilts = 5, kTurns = 9;

/// Readings so far, all that could come next, and the columns of the effects in question.
class Design {
 public:
  Design(const ObservationSet& so_far, const ObservationSet& next, const Machine& machine,
         const std::vector<std::string>& ids)
      : set_(joined(so_far, next)),
        first_next_(so_far.rows.size()),
        problem_(make_linear_problem(set_, machine)),
        design_(smooth_design(problem_, basis_for(problem_, 3), SmoothPrior{})) {
    CandidateScope scope{.context = effect_context(machine), .readings = problem_.situations};
    scope.columns = {"time_s", std::string(1, machine.tilt_letter()) + "_dir", "C_dir", "repeat"};
    if (set_.has_temperature) scope.columns.emplace_back("temperature_C");
    scope.columns.insert(scope.columns.end(), set_.extra_columns.begin(), set_.extra_columns.end());
    for (const std::string& a : set_.artifacts)
      if (!a.empty()) scope.artifacts.push_back(a);
    for (const std::string& id : ids) {
      const Family& family = family_of(id);
      std::vector<EffectPtr> found = family.candidates(scope);
      std::erase_if(found, [&](const EffectPtr& e) { return e->id() != id; });
      if (found.empty())
        throw UsageError("--separate " + id +
                         ": these readings carry nothing of it; what would: " + std::string(family.remedy));
      effects_.push_back(make_candidate(problem_, found[found.size() / 2]));  // of a scan, the middle
    }
    z_ = side_by_side(effects_, static_cast<Eigen::Index>(problem_.readings.size())).columns;
  }

  const std::vector<Candidate>& effects() const { return effects_; }

  struct Known {
    Eigen::MatrixXd information;        ///< Z' P Z of the readings so far
    std::vector<Eigen::MatrixXd> with;  ///< the same with each group of further readings
    Eigen::VectorXd norms;              ///< of the columns, over all readings
  };
  /// `groups`: rows of the next readings, by visit.
  Known known(const std::vector<std::vector<std::size_t>>& groups) const {
    const auto n = static_cast<Eigen::Index>(problem_.readings.size());
    std::vector<bool> used(static_cast<std::size_t>(n));
    std::vector<std::vector<Eigen::Index>> readings(groups.size());
    std::vector<std::size_t> group_of(set_.rows.size(), groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g)
      for (const std::size_t row : groups[g]) group_of[first_next_ + row] = g;
    for (Eigen::Index i = 0; i < n; ++i) {
      const std::size_t row = problem_.readings[static_cast<std::size_t>(i)].row;
      used[static_cast<std::size_t>(i)] = row < first_next_;
      if (group_of[row] < groups.size()) readings[group_of[row]].push_back(i);
    }
    const SmoothProjection base({&problem_, used, Eigen::VectorXd::Zero(n), {Eigen::MatrixXd(n, 0), Eigen::VectorXd()}},
                                design_);
    const Eigen::MatrixXd reduced = base.reduced(z_), masked = base.mask().asDiagonal() * z_;
    Known known{masked.transpose() * masked - reduced.transpose() * reduced, {}, z_.colwise().norm().transpose()};
    for (const std::vector<Eigen::Index>& rows : readings) {
      // New rows add E' (I + F F')^-1 E, E what is not foreseen of the effects there.
      const Eigen::MatrixXd f = base.predict(rows).factor, e = z_(rows, Eigen::all) - f * reduced;
      const Eigen::MatrixXd m = Eigen::MatrixXd::Identity(f.rows(), f.rows()) + f * f.transpose();
      known.with.push_back(known.information + e.transpose() * Cholesky(m).solve(e));
    }
    return known;
  }

  std::vector<SmallestSeen> smallest(const Eigen::MatrixXd& information, const Eigen::VectorXd& norms) const {
    const Eigen::VectorXd unit = norms.unaryExpr([](double x) { return x > 0 ? 1 / x : 0.0; });
    const Eigen::Index m = information.rows();
    const Eigen::MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
    std::vector<SmallestSeen> seen;
    Eigen::Index k = 0;
    for (const Candidate& c : effects_)
      for (std::size_t j = 0; j < c.effect->parameters().size(); ++j, ++k) {
        // What all other parameters cannot take over of this one.
        double left = scaled(k, k);
        if (m > 1) {
          std::vector<Eigen::Index> others;
          for (Eigen::Index i = 0; i < m; ++i)
            if (i != k) others.push_back(i);
          Eigen::MatrixXd rest = scaled(others, others);
          rest.diagonal().array() += 1e-12;
          const Eigen::VectorXd cross = scaled(others, k);
          left -= cross.dot(PivotedCholesky(rest).solve(cross));
        }
        const Parameter& p = c.effect->parameters()[j];
        const double size = left > kUnseen
                                ? std::sqrt(kDetectable / left) * unit[k] * c.scale[static_cast<Eigen::Index>(j)]
                                : std::numeric_limits<double>::infinity();
        seen.push_back({c.effect->id(), p.name, p.unit, size});
      }
    return seen;
  }

 private:
  ObservationSet set_;
  std::size_t first_next_;
  LinearProblem problem_;
  SmoothDesign design_;
  std::vector<Candidate> effects_;
  Eigen::MatrixXd z_;
};

double log_det(const Eigen::MatrixXd& information, const Eigen::VectorXd& norms) {
  const Eigen::VectorXd unit = norms.unaryExpr([](double x) { return x > 0 ? 1 / x : 0.0; });
  Eigen::MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  scaled.diagonal().array() += kUnseen;
  return Cholesky(scaled).half_log_determinant();
}

std::vector<Visit> possible_visits(const Machine& machine, const std::vector<Spot>& spots, const PowerOptions& options,
                                   int repeat) {
  const KinematicChain chain(machine);
  const Range<Angle> tilts = planned_tilts(machine, options.pace);
  std::vector<Visit> visits;
  const auto add = [&](IndexedPosition at, std::vector<std::size_t> touched) {
    if (touched.empty()) return;
    for (const int tilt : {-1, 1})
      for (const int turn : {-1, 1}) visits.push_back({at, touched, repeat, tilt, turn});
  };
  add({}, reachable(machine, chain, spots, {}));
  for (int i = 0; i < kTilts; ++i)
    for (int j = 0; j < kTurns; ++j) {
      const IndexedPosition at{tilts.high + (i / (kTilts - 1.0)) * (tilts.low - tilts.high),
                               Angle::degrees(360.0 * j / kTurns)};
      if (i == 0 && j == 0 && std::abs(at.a.in_degrees()) < 1e-9) continue;
      add(at, best_spots(machine, chain, spots, at, options.pace.touches));
    }
  return visits;
}

}  // namespace

PowerPlan plan_for_power(const ObservationSet& so_far, const Machine& machine, const std::vector<Spot>& spots,
                         const PowerQuestion& question, const PowerOptions& options) {
  int repeat = 0;
  double now_s = 0;
  for (const Observation& o : so_far.rows) repeat = std::max(repeat, o.repeat), now_s = std::max(now_s, o.time_s);
  const double last_s = now_s + options.most_s;
  const std::vector<Visit> possible = possible_visits(machine, spots, options, repeat);
  PowerPlan plan;
  ObservationSet readings = so_far;
  readings.has_time = true;
  readings.has_tilt_sense = readings.has_turn_sense = true;
  PlanOptions pace = options.pace;
  for (std::size_t step = 0; step <= options.visits; ++step) {
    // All that could come next stands at the same moment.
    ObservationSet next;
    std::vector<std::vector<std::size_t>> groups;
    std::vector<bool> in_time;
    pace.start_s = now_s;
    for (const Visit& visit : possible) {
      const ObservationSet one = planned_observations(machine, spots, {visit}, pace, "plan");
      groups.emplace_back();
      in_time.push_back(one.rows.back().time_s <= last_s);
      for (std::size_t r = 0; r < one.rows.size(); ++r) groups.back().push_back(next.rows.size() + r);
      if (next.rows.empty())
        next = one;
      else
        next.rows.insert(next.rows.end(), one.rows.begin(), one.rows.end());
    }
    const Design design(readings, next, machine, question.effects);
    const Design::Known known = design.known(groups);
    if (step == 0) plan.before = design.smallest(known.information, known.norms);
    plan.after = design.smallest(known.information, known.norms);
    if (step == options.visits || std::ranges::none_of(in_time, std::identity())) break;
    std::size_t best = 0;
    double most = -std::numeric_limits<double>::infinity();
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const double information = log_det(known.with[g], known.norms);
      if (in_time[g] && information > most + 1e-9) most = information, best = g;
    }
    const ObservationSet chosen = planned_observations(machine, spots, {possible[best]}, pace, "plan");
    now_s = chosen.rows.back().time_s;
    readings = joined(readings, chosen);
    plan.visits.push_back(possible[best]);
    if (options.progress) options.progress(plan.visits.size());
  }
  return plan;
}

}  // namespace trunnion
