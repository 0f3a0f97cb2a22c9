#include "postproc/model_field.h"

#include <gmock/gmock.h>

#include <cmath>

#include "kinematics/structure.h"
#include "model/effects/rotary_error_map.h"

namespace trunnion {
namespace {

Machine seed() {
  Machine machine;
  machine.structure = parse_structure("w C' A' Y' b X Z t");
  machine.axes = default_axes(machine.structure);
  return machine;
}

Model smooth_model(const Machine& machine) {
  std::vector<Angle> a, c;
  for (double tilt = -90; tilt <= 0; tilt += 30) a.push_back(Angle::degrees(tilt));
  for (double turn = 0; turn < 360; turn += 60) c.push_back(Angle::degrees(turn));
  RotaryMapContent content{.grid = zero_grid(a, c)};
  for (std::size_t i = 0; i < a.size(); ++i) {
    content.grid.tilt[i].rotation_rad = {3e-5 * std::sin(a[i].in_radians()), 1e-5 * a[i].in_radians(), 0};
    for (std::size_t j = 0; j < c.size(); ++j)
      content.grid.turn[i * c.size() + j].translation_mm = {0.01 * std::cos(c[j].in_radians()),
                                                            0.02 * std::sin(c[j].in_radians()), 0};
  }
  Model model;
  model.effects.push_back(std::make_shared<RotaryErrorMap>(content, effect_context(machine)));
  return model;
}

TEST(ModelField, BakedIsTheModelToAHundredthOfAMicron) {
  const Machine machine = seed();
  const Model model = smooth_model(machine);
  const Range<Angle> stroke{Angle::degrees(-120), Angle::degrees(30)};
  const ModelField direct(model, {}, stroke);
  ModelField baked(model, {}, stroke);
  ASSERT_TRUE(baked.bake(KinematicChain(machine)));
  EXPECT_EQ(baked.tilt_range(), (Range<Angle>{Angle::degrees(-90), Angle::degrees(0)}));
  for (double a = -90.2; a <= 0.2; a += 3.3)
    for (double c = -400; c < 400; c += 17) {
      Situation situation;
      situation.at = {Angle::degrees(a), Angle::degrees(c)};
      const PoseError meant = direct.at(situation), got = baked.at(situation);
      EXPECT_LT((meant.translation_mm - got.translation_mm).norm(), 1e-5);
      EXPECT_LT((meant.rotation_rad - got.rotation_rad).norm(), 4e-8);
      const auto slopes = direct.with_slopes(situation), fast = baked.with_slopes(situation);
      EXPECT_LT((slopes.by_a.rotation_rad - fast.by_a.rotation_rad).norm(), 5e-6) << a << " " << c;
      EXPECT_LT((slopes.by_c.rotation_rad - fast.by_c.rotation_rad).norm(), 5e-6);
    }
}

}  // namespace
}  // namespace trunnion
