#include "testpiece/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "geometric_errors/rotary_errors.h"
#include "geometric_errors/symbol.h"

namespace trunnion {
namespace {

/// The twelve rotary errors as a function of position, as an effect: exact, relative to the reference pose.
class RotaryMotion : public Effect {
 public:
  using Errors = std::function<RotaryErrors(IndexedPosition)>;
  RotaryMotion(std::shared_ptr<const KinematicChain> chain, Errors errors)
      : chain_(std::move(chain)), errors_(std::move(errors)) {}
  std::string id() const override { return "rotary_motion"; }
  Origin origin() const override { return Origin::machine; }
  std::vector<std::string> depends_on() const override { return {}; }
  Matrix6Xd basis(const Situation&) const override { return Matrix6Xd(6, 0); }
  PoseError at(const Situation& s) const override {
    return relative_pose_error(*chain_, s.at, errors_(s.at), errors_({}), {s.point_r_mm, s.tool_length_mm});
  }

 protected:
  std::shared_ptr<Effect> clone() const override { return std::make_shared<RotaryMotion>(*this); }

 private:
  std::shared_ptr<const KinematicChain> chain_;
  Errors errors_;
};

/// A piece with its path, cut again for one error after another.
class Bench {
 public:
  Bench(const TestPiece& piece, const EffectContext& context, const SensitivityOptions& options)
      : piece_(piece), chain_(context.chain), options_(options), surface_(evaluated_surface(piece)) {
    path_ = flank_milling_path(piece, *chain_, {.steps_per_turn = piece.points, .largest_turn = Angle::degrees(30)});
    for (const ToolPosition& p : path_) steepest_ = std::min(steepest_, p.at.a);
  }

  Angle steepest() const { return steepest_; }
  std::span<const ToolPosition> path() const { return path_; }
  std::vector<Situation> situations() const {
    std::vector<Situation> all;
    for (const ToolPosition& p : path_) all.push_back(situation_at(p, piece_.tool.length));
    return all;
  }

  /// Component `k` of the tilting axis or of C, `amount` times `shape` of the position.
  Sensitivity of(const std::string& name, bool of_turning_axis, std::size_t k,
                 const std::function<double(IndexedPosition)>& shape) const {
    const double amount = k < 3 ? options_.length.in_millimetres() : options_.angle.in_radians();
    return of(name, amount, component_unit(k), std::make_shared<RotaryMotion>(chain_, [=](IndexedPosition at) {
                Vector6d six = Vector6d::Zero();
                six[static_cast<Eigen::Index>(k)] = amount * shape(at);
                RotaryErrors errors;
                (of_turning_axis ? errors.turn : errors.tilt) = PoseError::from_vector(six);
                return errors;
              }));
  }

  /// An effect of the given amount.
  Sensitivity of(const std::string& name, double amount, Unit unit, EffectPtr effect) const {
    const Model model{.effects = {std::move(effect)}};
    const std::vector<ToolInWorkpiece> tools = actual_tools(path_, *chain_, model, piece_.tool.length);
    const std::vector<ConeTrace> traces =
        traces_of(piece_, surface_, first_order_deviation_mm(piece_, surface_, path_, tools));
    Sensitivity found{.error = name,
                      .amount = to_unit(amount, unit),
                      .unit = unit,
                      .shown = evaluate_cone(traces, piece_.cone.half_angle)};
    double roundness = 0;
    for (std::size_t j = 0; j < traces.size(); ++j) {
      const HeightEvaluation& at = found.shown.heights[j];
      found.size_mm += (at.diameter_mm - 2 * traces[j].nominal_radius_mm) / static_cast<double>(traces.size());
      roundness = std::max(roundness, at.lsc_mm);
    }
    const double visible = options_.visible.in_millimetres();
    if (roundness >= visible) found.seen_in.push_back("roundness");
    if (found.shown.form_mm >= visible) found.seen_in.push_back("form");
    if (std::abs(found.size_mm) >= visible) found.seen_in.push_back("size");
    if (std::abs(found.shown.conicity_mm.value_or(0)) >= visible) found.seen_in.push_back("half angle");
    return found;
  }

  Sensitivity of(const LocationError& error) const {
    return of(error.symbol, error.of_turning_axis, error.component, [](IndexedPosition) { return 1.0; });
  }

 private:
  TestPiece piece_;
  std::shared_ptr<const KinematicChain> chain_;
  SensitivityOptions options_;
  SurfaceGrid surface_;
  std::vector<ToolPosition> path_;
  Angle steepest_;
};

/// EXX X, EYX X^2, EAX X: what moves, over the axis along which it grows. Squarenesses have their symbol, a backlash
/// its effect's name.
std::string motion_name(const Effect& effect, std::size_t k) {
  const std::string id = effect.id(), family = id.substr(0, id.find(':'));
  if (family == "linear_backlash") return id;
  if (family == "squareness") return effect.parameters()[k].name;
  const std::string symbol = family == "linear_scale" ? effect.parameters()[k].name : id.substr(id.find(':') + 1);
  return symbol + " " + symbol.back() + (family == "straightness" ? (k == 0 ? "^2" : "^3") : "");
}

/// The errors of the linear axes, one parameter after another: squarenesses and reversals of the given amount, motions
/// so large that they reach it somewhere on the path.
std::vector<Sensitivity> of_linear_axes(const Bench& bench, const EffectContext& context,
                                        const SensitivityOptions& options) {
  const std::vector<Situation> path = bench.situations();
  std::vector<Sensitivity> found;
  for (const char* family : {"squareness", "linear_scale", "straightness", "linear_angular", "linear_backlash"})
    for (const EffectPtr& effect : family_of(family).candidates({.context = context, .readings = path}))
      for (std::size_t k = 0; k < effect->parameters().size(); ++k) {
        double way = 0, turn = 0;
        for (const Situation& s : path) {
          const Vector6d moved = effect->basis(s).col(static_cast<Eigen::Index>(k));
          way = std::max(way, moved.head<3>().norm());
          turn = std::max(turn, moved.tail<3>().norm());
        }
        const Unit unit = effect->parameters()[k].unit;
        const bool turns = unit == Unit::urad || turn > 0;
        const double amount = turns ? options.angle.in_radians() : options.length.in_millimetres();
        const double per_parameter = unit == Unit::urad || unit == Unit::um ? 1 : turns ? turn : way;
        Eigen::VectorXd parameters = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(effect->parameters().size()));
        if (per_parameter > 0) parameters[static_cast<Eigen::Index>(k)] = amount / per_parameter;
        found.push_back(bench.of(motion_name(*effect, k), amount, turns ? Unit::urad : Unit::um,
                                 effect->with_parameters(parameters, {})));
      }
  return found;
}

double largest_lsc_mm(const Sensitivity& s) {
  double most = 0;
  for (const HeightEvaluation& at : s.shown.heights) most = std::max(most, at.lsc_mm);
  return most;
}

}  // namespace

bool Sensitivity::seen_in_roundness() const { return std::ranges::find(seen_in, "roundness") != seen_in.end(); }

std::vector<Sensitivity> sensitivities(const TestPiece& piece, const EffectContext& context,
                                       const SensitivityOptions& options) {
  const Bench bench(piece, context, options);
  std::vector<Sensitivity> found;
  for (const LocationError& error : location_errors(context.tilt_letter)) found.push_back(bench.of(error));
  const double steepest = bench.steepest().in_radians() != 0 ? bench.steepest().in_radians() : 1;
  for (std::size_t k = 0; k < 6; ++k)
    for (int order = 1; order <= 3; ++order) {
      const std::string power = order == 1 ? "" : "^" + std::to_string(order);
      found.push_back(bench.of(error_symbol(k, context.tilt_letter) + " " + context.tilt_letter + power, false, k,
                               [=](IndexedPosition at) { return std::pow(at.a.in_radians() / steepest, order); }));
    }
  for (std::size_t k = 0; k < 6; ++k)
    for (int order = 1; order <= 3; ++order) {
      const std::string multiple = (order == 1 ? "" : std::to_string(order)) + std::string("C");
      found.push_back(bench.of(error_symbol(k, 'C') + " cos " + multiple, true, k,
                               [=](IndexedPosition at) { return std::cos(order * at.c.in_radians()); }));
      found.push_back(bench.of(error_symbol(k, 'C') + " sin " + multiple, true, k,
                               [=](IndexedPosition at) { return std::sin(order * at.c.in_radians()); }));
    }
  const double amount = options.angle.in_radians();
  for (const EffectPtr& backlash : family_of("backlash").candidates({.context = context}))
    found.push_back(bench.of(backlash->id(), amount, Unit::urad,
                             backlash->with_parameters(Eigen::VectorXd::Constant(1, amount), {})));
  for (Sensitivity& linear : of_linear_axes(bench, context, options)) found.push_back(std::move(linear));
  return found;
}

BetterPiece better_piece(const TestPiece& piece, const EffectContext& context, const Reachable& reachable,
                         const SensitivityOptions& options) {
  const auto errors = location_errors(context.tilt_letter);
  struct Candidate {
    TestPiece piece;
    std::vector<double> shown_mm;
  };
  const auto shown_by = [&](const Bench& bench, const TestPiece& p) {
    Candidate candidate{p, {}};
    for (const LocationError& error : errors) candidate.shown_mm.push_back(largest_lsc_mm(bench.of(error)));
    return candidate;
  };
  std::vector<Candidate> candidates = {shown_by(Bench(piece, context, options), piece)};
  for (const double half_angle : {10.0, 15.0, 30.0, 45.0})
    for (const double tilt : {5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 70.0})
      for (const double raised : {0.0, 50.0, 100.0}) {
        TestPiece other = piece;
        other.cone.half_angle = Angle::degrees(half_angle);
        other.cone.tilt = Angle::degrees(tilt);
        other.cone.base_center_w_mm.z() += raised;
        // The flank must reach its top; close to half angle = tilt C runs wild.
        if (radius_at(other.cone, other.cone.height) <= Length::millimetres(1) || std::abs(half_angle - tilt) < 3)
          continue;
        const Bench bench(other, context, options);
        if (reachable(bench.path())) candidates.push_back(shown_by(bench, other));
      }
  BetterPiece result;
  std::vector<std::size_t> visible;
  for (std::size_t e = 0; e < errors.size(); ++e) {
    const bool ever = std::ranges::any_of(
        candidates, [&](const Candidate& c) { return c.shown_mm[e] >= options.visible.in_millimetres(); });
    if (ever)
      visible.push_back(e);
    else
      result.never.push_back(errors[e].symbol);
  }
  const auto least = [&](const Candidate& c) {
    double least_mm = std::numeric_limits<double>::infinity();
    for (const std::size_t e : visible) least_mm = std::min(least_mm, c.shown_mm[e]);
    return visible.empty() ? 0 : least_mm;
  };
  const Candidate& best = *std::ranges::max_element(candidates, {}, least);
  result.piece = best.piece;
  result.least_seen_mm = least(best);
  result.least_seen_here_mm = least(candidates.front());
  return result;
}

}  // namespace trunnion
