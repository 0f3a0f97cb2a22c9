#include "testpiece/piece_solid.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "error.h"
#include "testpiece/pieces.h"

namespace trunnion {
namespace {

const std::string kModule = TRUNNION_BREP_MODULE;

TEST(PieceSolid, ReadsBackWithTheVolumeAndTheConeOfThePiece) {
  for (const auto& [half_angle, tilt, faces] : {std::tuple{15.0, 10.0, 8}, {45.0, 30.0, 8}, {0.0, 20.0, 8}}) {
    TestPiece piece = usual_piece(half_angle, tilt);
    piece.cone.tilt_azimuth = Angle::degrees(70);
    const MeasuredSolid solid = measured_solid(piece_step(piece, kModule), kModule);
    const double r = 40, top = 40 - 20 * std::tan(half_angle * std::numbers::pi / 180);
    const double frustum = std::numbers::pi * 20 / 3 * (r * r + r * top + top * top), block = 52.0 * 52 * 20;
    EXPECT_NEAR(solid.volume_mm3 / (frustum + block), 1, 1e-6) << half_angle;
    EXPECT_EQ(solid.faces, faces) << half_angle;
    EXPECT_NEAR(solid.semi_angle.in_degrees(), half_angle, 1e-9);
  }
}

TEST(PieceSolid, IsTheSameTextEveryTime) {
  const std::string text = piece_step(usual_piece(15, 10), kModule);
  EXPECT_TRUE(piece_step(usual_piece(15, 10), kModule) == text);
  EXPECT_EQ(text.rfind("ISO-10303-21;", 0), 0U);
  EXPECT_NE(text.find("AP242"), std::string::npos);
}

TEST(PieceSolid, ItsOwnSurfaceGuidesTheToolWhereTheFormulaDoes) {
  constexpr double kRounding = 1e-11;  // mm, and unit vectors: double rounding on 100 mm, near upright times 1/angle
  for (const auto& [half_angle, tilt, azimuth] :
       {std::tuple{15.0, 10.0, 0.0}, {45.0, 30.0, -140.0}, {15.0, 30.0, 70.0}, {0.0, 20.0, 33.0}, {30.0, 0.0, 0.0}}) {
    TestPiece piece = usual_piece(half_angle, tilt);
    piece.cone.tilt_azimuth = Angle::degrees(azimuth);
    const KinematicChain chain(trunnion_machine());
    const PathSampling sampling{.steps_per_turn = 1080};
    const std::vector<ToolPosition> by_solid =
        flank_milling_path(piece, chain, sampling, solid_rulings(piece, kModule));
    const std::vector<ToolPosition> by_formula = flank_milling_path(piece, chain, sampling);
    ASSERT_EQ(by_solid.size(), by_formula.size()) << half_angle << '/' << tilt;
    for (std::size_t i = 0; i < by_solid.size(); ++i) {
      EXPECT_LT((by_solid[i].nominal.tip_w_mm - by_formula[i].nominal.tip_w_mm).norm(), kRounding) << i;
      EXPECT_LT((by_solid[i].nominal.axis_w - by_formula[i].nominal.axis_w).norm(), kRounding) << i;
      EXPECT_LT((by_solid[i].tip_r_mm - by_formula[i].tip_r_mm).norm(), 1e3 * kRounding) << i;
    }
  }
}

TEST(PieceSolid, SaysWhatIsMissing) {
  EXPECT_THROW(piece_step(usual_piece(15, 10), "/nowhere/trunnion_brep.so"), ModelError);
  EXPECT_THROW(measured_solid("not STEP", kModule), ModelError);
}

}  // namespace
}  // namespace trunnion
