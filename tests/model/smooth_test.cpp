#include "model/effects/smooth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "error.h"

namespace trunnion {
namespace {

using nlohmann::json;

EffectContext context_of(const std::string& structure) {
  Machine machine;
  machine.structure = parse_structure(structure);
  machine.axes = default_axes(machine.structure);
  return effect_context(machine);
}

/// Prior covariance of f(u) - f(0) and f(v) - f(0) by the functions, against the kernel's own.
TEST(SmoothTerm, IsAGaussianProcessWithItsKernelAtReducedRank) {
  const EffectContext context = context_of("w C' A' Y' b X Z t");
  for (const double length : {40.0, 120.0, 300.0}) {
    const auto term = make_smooth({{"x_mm", -150, 150, length}}, SmoothDirection::z, context);
    const auto k = [length](double u, double v) { return std::exp(-(u - v) * (u - v) / (2 * length * length)); };
    for (const double u : {-140.0, -20.0, 75.0, 150.0, 400.0})
      for (const double v : {-150.0, 10.0, 120.0}) {
        Situation at_u, at_v;
        at_u.point_r_mm.x() = u;
        at_v.point_r_mm.x() = v;
        const double by_functions =
            term->functions(at_u).dot(term->prior_variances().asDiagonal() * term->functions(at_v));
        const double held = std::min(u, 150.0);  // at the end of its range
        EXPECT_NEAR(by_functions, k(held, v) - k(held, 0) - k(0, v) + 1, 0.01) << length << " at " << u << ", " << v;
      }
  }
  const auto circle = make_smooth({{"C_deg", 0, 360, 50}}, SmoothDirection::table_x, context);
  Situation a, b;
  a.at.c = Angle::degrees(350), b.at.c = Angle::degrees(-10);
  EXPECT_LT((circle->functions(a) - circle->functions(b)).norm(), 1e-12);
}

/// A smooth turn about an axis is what the exact chain does when that axis stands a little further.
TEST(SmoothTerm, TurnsAsItsAxisTurns) {
  constexpr double kSmall_rad = 1e-6;
  for (const char* structure : {"w C' A' Y' b X Z t", "w C' B' Y' b X Z t", "w Y' b X Z A C t", "w C' b Y X Z A t"}) {
    const EffectContext context = context_of(structure);
    for (const SmoothDirection direction : {SmoothDirection::about_tilt, SmoothDirection::about_turn}) {
      const auto term = make_smooth({{"time_s", 0, 100, 50}}, direction, context);
      Situation s;
      s.at = {Angle::degrees(-33), Angle::degrees(71)};
      s.time_s = 60;
      const auto n = static_cast<Eigen::Index>(term->parameters().size());
      const Eigen::VectorXd beta = Eigen::VectorXd::LinSpaced(n, 1, 2);
      const EffectPtr sized = term->with_parameters(kSmall_rad / term->functions(s).dot(beta) * beta, {});
      Situation further = s;
      (direction == SmoothDirection::about_tilt ? further.at.a : further.at.c) =
          (direction == SmoothDirection::about_tilt ? s.at.a : s.at.c) + Angle::radians(kSmall_rad);
      // Workpiece relative to tool, at a point of R: tool frames there and back where an axis carries the tool.
      const KinematicChain& chain = *context.chain;
      const auto relative = [&](const Situation& at) {
        return chain.r_from_t(at.at).inverse() * chain.r_from_w(at.at);
      };
      const Eigen::Isometry3d moved =
          chain.r_from_t(s.at) * relative(further) * relative(s).inverse() * chain.r_from_t(s.at).inverse();
      const PoseError e = sized->at(s);
      EXPECT_NEAR(e.rotation_rad.norm(), kSmall_rad, 1e-3 * kSmall_rad) << structure;
      const Eigen::Matrix3d turned = moved.linear() - Eigen::Matrix3d::Identity();
      EXPECT_LT((e.rotation_rad - Eigen::Vector3d(turned(2, 1), turned(0, 2), turned(1, 0))).norm(), 1e-11)
          << structure;
      EXPECT_LT((e.translation_mm - moved.translation()).norm(), 1e-8) << structure;
    }
  }
}

TEST(SmoothTerm, ComesBackFromItsFileAndKnowsWhoseItIs) {
  const EffectContext context = context_of("w C' A' Y' b X Z t");
  const std::vector<std::string> names = {"spindle_C"};
  const std::vector<double> values = {21.5};
  Situation touched;
  touched.at = {Angle::degrees(-60), Angle::degrees(240)};
  touched.point_r_mm = {-83, 40, 95};
  touched.approach_r = Eigen::Vector3d(0.8, -0.5, 0.3).normalized();
  touched.reading = ReadingKind::contact;
  touched.time_s = 700;
  touched.tilt_sense = touched.turn_sense = -1;
  touched.extra = {&names, values.data()};
  const auto check = [&](const std::vector<SmoothAxis>& axes, SmoothDirection direction, Origin origin) {
    const auto term = make_smooth(axes, direction, context);
    EXPECT_EQ(term->origin(), origin) << term->id();
    EXPECT_EQ(term->basis(Situation()).norm(), 0) << term->id();
    const auto n = static_cast<Eigen::Index>(term->parameters().size());
    EXPECT_EQ(term->prior_variances().size(), n);
    const EffectPtr written =
        term->with_parameters(Eigen::VectorXd::LinSpaced(n, -1e-3, 2e-3), 1e-8 * Eigen::MatrixXd::Identity(n, n));
    const EffectPtr read = read_effect(json::parse(written->to_json().dump()), context);
    EXPECT_EQ(read->id(), written->id());
    EXPECT_GT(written->at(touched).vector().norm(), 0) << term->id();
    EXPECT_LT((read->at(touched).vector() - written->at(touched).vector()).norm(), 1e-12);
  };
  check({{"time_s", 0, 2000, 400}}, SmoothDirection::y, Origin::machine);
  check({{"time_s", 0, 2000, 400}}, SmoothDirection::approach, Origin::measurement);
  check({{"xw_mm", -150, 150, 60}}, SmoothDirection::table_z, Origin::machine);
  check({{"spindle_C", 20, 23, 1}}, SmoothDirection::approach_z, Origin::measurement);
  check({{"nz", -1, 1, 0.5}}, SmoothDirection::x, Origin::measurement);
  check({{"time_s~1200", 0, 1200, 200}}, SmoothDirection::z, Origin::machine);
  check({{"spindle_C", 20, 23, 1}, {"A_deg", -90, 0, 40}}, SmoothDirection::z, Origin::machine);
  check({{"C_deg", 0, 360, 60}, {"A_deg", -90, 0, 40}}, SmoothDirection::table_y, Origin::machine);
  check({{"A_dir", -1, 1, 1}, {"A_deg", -90, 0, 40}}, SmoothDirection::about_tilt, Origin::machine);
  check({{"C_deg", 0, 360, 60}, {"time_s", 0, 2000, 400}}, SmoothDirection::about_turn, Origin::machine);
  EXPECT_THROW(make_smooth({{"x_mm", 1, 1, 2}}, SmoothDirection::x, context), ModelError);
  EXPECT_THROW(make_smooth({{"x_mm", 0, 1, 0}}, SmoothDirection::x, context), ModelError);
}

}  // namespace
}  // namespace trunnion
