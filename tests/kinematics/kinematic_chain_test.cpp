#include "kinematics/kinematic_chain.h"

#include <gtest/gtest.h>

#include "support/noise.h"
#include "support/twin.h"

namespace trunnion {
namespace {

using Eigen::Vector3d;

constexpr double kRounding_mm = 1e-12;  // some roundings of a few hundred mm

TEST(KinematicChain, PlacesTheTableWhereTheExactProductPlacesIt) {
  testing::Noise noise(1);
  for (const auto& [name, both] : twins()) {
    const KinematicChain chain(both.machine);
    for (int k = 0; k < 50; ++k) {
      const IndexedPosition at = degrees(noise.uniform(-120, 120), noise.uniform(-720, 720));
      const Eigen::Isometry3d wanted = both.exact.r_from_w_nominal(exact_position(both.machine, at));
      EXPECT_LT((chain.r_from_w(at).matrix() - wanted.matrix()).cwiseAbs().maxCoeff(), kRounding_mm) << name;
    }
  }
}

TEST(KinematicChain, WorkpieceAndReferenceFrameCoincideAtTheReferencePose) {
  for (const auto& [name, both] : twins())
    EXPECT_LT((KinematicChain(both.machine).r_from_w({}).matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-15) << name;
}

TEST(KinematicChain, TurnsRightHandedOnTheSeedMachine) {
  const KinematicChain chain(twin("w C' A' Y' b X Z t").machine);
  // p_r = Rx(A) Rz(C) p_w: C first brings X to Y, then A = -90 brings Y to -Z.
  EXPECT_LT((chain.r_from_w(degrees(-90, 90)) * Vector3d(1, 0, 0) - Vector3d(0, 0, -1)).norm(), 1e-15);
  EXPECT_LT((chain.r_from_w(degrees(-90, 0)) * Vector3d(0, 0, 1) - Vector3d(0, 1, 0)).norm(), 1e-15);
}

TEST(KinematicChain, TurnsTheOtherWayWhereTheFileSaysSo) {
  const Vector3d x = Vector3d::UnitX(), z = Vector3d::UnitZ();
  const KinematicChain reversed(twin("w C' A' Y' b X Z t", {{'A', {-x}}, {'C', {-z}}}).machine);
  const KinematicChain usual(twin("w C' A' Y' b X Z t").machine);
  EXPECT_LT((reversed.r_from_w(degrees(-33, 71)).matrix() - usual.r_from_w(degrees(33, -71)).matrix()).norm(), 1e-14);
}

TEST(KinematicChain, PlacesTheTipWhereTheExactToolSidePlacesIt) {
  testing::Noise noise(2);
  for (const auto& [name, both] : twins()) {
    const KinematicChain chain(both.machine);
    EXPECT_EQ(chain.has_rotary(Side::tool), !both.exact.tool_axes.empty()) << name;
    for (int k = 0; k < 50; ++k) {
      const IndexedPosition at = degrees(noise.uniform(-100, 100), noise.uniform(-360, 360));
      const double length = noise.uniform(0, 200);
      testing::Command command;
      command.rotary = exact_position(both.machine, at);
      command.tool_length_mm = length;
      const testing::MachineState state = both.exact.commanded_state(command);
      // With the linear axes at zero the spindle's reference point stands `length` above the told tip.
      const Vector3d tip = chain.r_from_t(at) * Vector3d(0, 0, -length) + Vector3d(0, 0, length);
      EXPECT_LT((tip - state.tip_r_mm).norm(), kRounding_mm) << name;
      const Vector3d axis = chain.r_from_t(at).linear() * Vector3d::UnitZ();
      EXPECT_LT((axis - both.exact.r_from_tool_nominal(state).linear() * Vector3d::UnitZ()).norm(), 1e-14) << name;
    }
  }
}

TEST(KinematicChain, KnowsWhichAxisCarriesWhich) {
  std::map<std::string, Twin> all = twins();
  EXPECT_FALSE(KinematicChain(all.at("crossing").machine).turn_carries_tilt());
  EXPECT_TRUE(KinematicChain(all.at("turn carries tilt").machine).turn_carries_tilt());
  EXPECT_TRUE(KinematicChain(all.at("fork head").machine).turn_carries_tilt());
  EXPECT_FALSE(KinematicChain(all.at("head and table").machine).turn_carries_tilt());
  EXPECT_TRUE(KinematicChain(all.at("crossing").machine).tilt_carries_turn());
  EXPECT_FALSE(KinematicChain(all.at("turn carries tilt").machine).tilt_carries_turn());
  EXPECT_FALSE(KinematicChain(all.at("head C, table A").machine).tilt_carries_turn());
  for (const auto& [name, both] : all) {
    const KinematicChain chain(both.machine);
    EXPECT_EQ(chain.rotary_joints()[chain.tilt_index()].letter, both.machine.tilt_letter()) << name;
    EXPECT_EQ(chain.rotary_joints()[chain.turn_index()].letter, 'C') << name;
  }
}

}  // namespace
}  // namespace trunnion
