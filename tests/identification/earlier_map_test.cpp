#include "identification/earlier_map.h"

#include <gmock/gmock.h>

#include <cmath>

#include "error.h"
#include "identification/as_observations.h"
#include "identification/identify.h"
#include "model/effects/rotary_error_map.h"
#include "support/probing_plan.h"
#include "support/smooth_machine.h"

namespace trunnion {
namespace {

using testing::AxisErrors;
using testing::RotaryPosition;
using testing::VirtualMachine;

constexpr double kDrift_mm = 1.5e-3, kDrift_rad = 6e-6;
constexpr double kProbe_mm = 0.175e-3;

/// The machine after a drift drawn from what `Drift` says, written out: the constants as large as told, degrees of the
/// tilt and functions of the tilt in C falling off by exp(-0.8), harmonics of C by a half.
VirtualMachine drifted(VirtualMachine machine, testing::Noise& noise, double size = 1) {
  const HarmonicBasis basis{
      .a_range = {Angle::degrees(-90), Angle()}, .tilt_degree = 4, .harmonics = 3, .turn_degree = 2};
  Eigen::VectorXd beta(basis.coefficient_count());
  for (Eigen::Index f = 0; f < beta.size() / 6; ++f) {
    double factor = size;
    if (f < basis.tilt_functions()) {
      factor *= std::exp(-0.8 * static_cast<double>(f));
    } else if (f > basis.tilt_functions()) {
      const Eigen::Index g = f - basis.tilt_functions() - 1;
      factor *= std::exp(-0.8 * static_cast<double>(g % 3)) * std::pow(0.5, static_cast<double>(g / 6));
    }
    for (Eigen::Index k = 0; k < 6; ++k) beta[6 * f + k] = factor * (k < 3 ? kDrift_mm : kDrift_rad) * noise.normal();
  }
  const auto surface = std::make_shared<HarmonicSurface>(basis, beta);
  for (const char axis : {'A', 'C'}) {
    const auto before = machine.axis(axis).errors;
    machine.axis(axis).errors = [=](const RotaryPosition& q) {
      AxisErrors e = before(q);
      const RotaryErrors moved = surface->at({Angle::radians(q.A_rad), Angle::radians(q.C_rad)});
      const PoseError& by = axis == 'A' ? moved.tilt : moved.turn;
      e.translation_mm += by.translation_mm;
      e.rotation_rad += by.rotation_rad;
      return e;
    };
  }
  return machine;
}

ObservationSet probed(const VirtualMachine& machine, std::uint64_t seed,
                      const std::function<bool(double, double)>& where) {
  testing::Noise noise(seed);
  testing::ProbingPlan plan = testing::replica_plan();
  plan.faces = testing::as_built(plan.faces, noise, 20e-3, 50e-6);
  std::erase_if(plan.touches, [&](const testing::PlannedTouch& t) { return !where(t.A_deg, t.C_deg); });
  return testing::as_observations(testing::probe(machine, plan, {.sigma_mm = kProbe_mm}, noise));
}

bool everywhere(double, double) { return true; }
/// Five positions of the twenty-four, the reference among them: a quick check.
bool in_a_few_places(double a_deg, double c_deg) {
  return (a_deg == 0 && (c_deg == 0 || c_deg == 180)) || (a_deg == -90 && (c_deg == 0 || c_deg == 120 || c_deg == 240));
}

std::shared_ptr<const RotaryErrorMap> map_of(const IdentificationResult& result) {
  return std::dynamic_pointer_cast<const RotaryErrorMap>(result.model.effects[0]);
}

/// Deviation of a model from the machine at a lever, in mm, and in units of its stated uncertainty.
struct Missed {
  double square_mm2 = 0, normalised2 = 0, count = 0;
  void add(const Model& model, const VirtualMachine& machine) {
    for (const double a : {-90.0, -70.0, -45.0, -20.0, 0.0})
      for (const double c : {20.0, 100.0, 180.0, 260.0, 330.0}) {
        Situation s;
        s.at = {Angle::degrees(a), Angle::degrees(c)};
        s.point_r_mm = {60, -40, 80};
        testing::MachineState state;
        state.rotary = testing::ac_degrees(a, c);
        state.tip_r_mm = s.point_r_mm;
        const Eigen::Vector3d off = deviation_mm(model, s) - machine.deviation_mm(state);
        const Eigen::Matrix3d covariance = deviation_covariance_mm2(model, s);
        for (Eigen::Index k = 0; k < 3; ++k) {
          square_mm2 += off[k] * off[k];
          normalised2 += off[k] * off[k] / covariance(k, k);
          ++count;
        }
      }
  }
  double rms_um() const { return 1e3 * std::sqrt(square_mm2 / count); }
  double normalised() const { return std::sqrt(normalised2 / count); }
};

TEST(EarlierMap, MakesAQuickCheckAsGoodAsItsUncertaintySays) {
  const Machine file = testing::plain_machine();
  constexpr int kMachines = 12;
  Missed with, without, before;
  int contradicted = 0;
  for (std::uint64_t m = 0; m < kMachines; ++m) {
    testing::Noise noise(900 + m);
    const VirtualMachine then = testing::smooth_machine(60 + m);
    const ObservationSet first = probed(then, 2000 + m, everywhere);
    const IdentificationResult earlier = identify(first, file, {.interpolation = "gaussian-process"});
    const VirtualMachine now = drifted(then, noise);
    const ObservationSet check = probed(now, 3000 + m, in_a_few_places);
    const IdentificationResult result = identify(
        check, file,
        {.earlier = EarlierMap{map_of(earlier), {Length::millimetres(kDrift_mm), Angle::radians(kDrift_rad)}}});
    ASSERT_TRUE(result.belief);
    contradicted += result.belief->p_value < 0.01 ? 1 : 0;
    with.add(result.model, now);
    without.add(identify(check, file, {.fill = true}).model, now);
    before.add(earlier.model, now);
  }
  // Stated uncertainties are right to a fifth: 12 machines, about 20 independent freedoms each, would scatter by 5 %.
  EXPECT_NEAR(with.normalised(), 1, 0.2);
  EXPECT_LT(with.rms_um(), 0.6 * without.rms_um());
  EXPECT_LT(with.rms_um(), 0.6 * before.rms_um());
  EXPECT_LE(contradicted, 1);
  RecordProperty("with_um", std::to_string(with.rms_um()));
  RecordProperty("without_um", std::to_string(without.rms_um()));
  RecordProperty("before_um", std::to_string(before.rms_um()));
}

TEST(EarlierMap, IsContradictedByAMachineThatMovedFurther) {
  const Machine file = testing::plain_machine();
  testing::Noise noise(5);
  const VirtualMachine then = testing::smooth_machine(33);
  const IdentificationResult earlier = identify(probed(then, 1, everywhere), file);
  const ObservationSet check = probed(drifted(then, noise, 10), 2, in_a_few_places);
  const IdentificationResult result =
      identify(check, file,
               {.earlier = EarlierMap{map_of(earlier), {Length::millimetres(kDrift_mm), Angle::radians(kDrift_rad)}}});
  EXPECT_LT(result.belief->p_value, 1e-3);
}

TEST(EarlierMap, SaysNothingWhereTheMachineMayHaveMovedFar) {
  const Machine file = testing::plain_machine();
  const VirtualMachine then = testing::smooth_machine(34), now = testing::smooth_machine(35);
  const IdentificationResult earlier = identify(probed(then, 1, everywhere), file);
  const ObservationSet set = probed(now, 2, everywhere);
  const IdentificationResult alone = identify(set, file, {.interpolation = "gaussian-process"});
  const IdentificationResult result =
      identify(set, file, {.earlier = EarlierMap{map_of(earlier), {Length::millimetres(10), Angle::radians(1e-2)}}});
  Missed with, without;
  with.add(result.model, now);
  without.add(alone.model, now);
  EXPECT_LT(with.rms_um(), 1.3 * without.rms_um() + 0.02);
}

TEST(EarlierMap, IsCarriedIntoAWiderBasisUnchanged) {
  // The earlier map covers A -90 … 0 with few harmonics; the readings now reach from -100 to 20 and ask for more.
  const Machine file = testing::plain_machine();
  const ObservationSet set = probed(testing::smooth_machine(36), 1, everywhere);
  const IdentificationResult earlier = identify(set, file, {.interpolation = "gaussian-process"});
  HarmonicBasis wider = *map_of(earlier)->content().smooth_basis;
  wider.a_range = {Angle::degrees(-100), Angle::degrees(20)};
  wider.harmonics += 2;
  const LinearProblem problem = make_linear_problem(set, file);
  const CarriedMap carried = carried_over(*map_of(earlier), problem, wider, {}, {});
  const HarmonicSurface surface(carried.basis, carried.belief.mean);
  constexpr double kRounding = 1e-12;
  for (const double a : {-90.0, -33.0, 0.0})
    for (const double c : {0.0, 77.0, 290.0}) {
      const IndexedPosition at{Angle::degrees(a), Angle::degrees(c)};
      const RotaryErrors was = map_of(earlier)->surface().at(at), is = surface.at(at);
      EXPECT_LT((was.tilt.vector() - is.tilt.vector()).cwiseAbs().maxCoeff(), kRounding);
      EXPECT_LT((was.turn.vector() - is.turn.vector()).cwiseAbs().maxCoeff(), kRounding);
    }
}

TEST(EarlierMap, ComesFromNodesAlone) {
  const Machine file = testing::plain_machine();
  const VirtualMachine machine = testing::smooth_machine(37);
  const IdentificationResult nodes = identify(probed(machine, 1, everywhere), file, {.interpolation = "trig-cubic"});
  const ObservationSet check = probed(machine, 2, in_a_few_places);
  const IdentificationResult result = identify(
      check, file, {.earlier = EarlierMap{map_of(nodes), {Length::micrometres(0.1), Angle::microradians(0.5)}}});
  Missed missed;
  missed.add(result.model, machine);
  EXPECT_LT(missed.rms_um(), 0.5);
  EXPECT_LT(missed.normalised(), 1.5);
}

TEST(EarlierMap, NeedsItsUncertainty) {
  const Machine file = testing::plain_machine();
  const ObservationSet set = probed(testing::smooth_machine(38), 1, everywhere);
  RotaryMapContent content = map_of(identify(set, file, {.interpolation = "trig-cubic"}))->content();
  content.grid_covariance.resize(0, 0);
  const auto bare = std::make_shared<RotaryErrorMap>(std::move(content), effect_context(file));
  EXPECT_THROW(identify(set, file, {.earlier = EarlierMap{bare, {}}}), ModelError);
}

}  // namespace
}  // namespace trunnion
