#include "io/piece_file.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "error.h"
#include "io/prediction_file.h"
#include "testpiece/pieces.h"

namespace trunnion {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string kPiece = R"(format = "trunnion-piece"
version = 1
kind = "cone_frustum"
half_angle_deg = 15
base_diameter_mm = 80
height_mm = 20
base_center_mm = [40, 0, 60]   # W
tilt_deg = 10
tilt_azimuth_deg = 90
[tool]
diameter_mm = 20
overhang_mm = 2
[path]
sense = -1
[evaluate]
heights_mm = [2, 10, 18]
points = 360
)";

std::string with(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

std::string message(const std::string& text) {
  try {
    parse_piece(text, "p.toml");
  } catch (const InputError& e) {
    return e.what();
  }
  return "nothing was refused";
}

TEST(PieceFile, SaysWhatIsCutAndWhereItIsEvaluated) {
  const TestPiece piece = parse_piece(kPiece, "p.toml");
  EXPECT_NEAR(piece.cone.half_angle.in_degrees(), 15, 1e-12);
  EXPECT_EQ(piece.cone.base_diameter, Length::millimetres(80));
  EXPECT_EQ(piece.cone.base_center_w_mm, Eigen::Vector3d(40, 0, 60));
  EXPECT_NEAR(piece.cone.tilt_azimuth.in_degrees(), 90, 1e-12);
  EXPECT_EQ(piece.tool.overhang, Length::millimetres(2));
  EXPECT_EQ(piece.tool.corner_radius, Length());
  EXPECT_EQ(piece.sense, -1);
  EXPECT_EQ(piece.heights.size(), 3U);
  EXPECT_EQ(piece.points, 360);
  EXPECT_FALSE(piece.feed_mm_per_min);
}

TEST(PieceFile, ComesBackFromItsOwnText) {
  TestPiece piece = parse_piece(kPiece, "p.toml");
  piece.feed_mm_per_min = 750;
  piece.tool.corner_radius = Length::millimetres(0.5);
  const std::string text = piece_text(piece);
  EXPECT_EQ(piece_text(parse_piece(text, "again.toml")), text);
}

TEST(PieceFile, HeightsAreNearTheEndsAndInTheMiddleWhereNoneAreTold) {
  const TestPiece piece = parse_piece(with(kPiece, "heights_mm = [2, 10, 18]\n", ""), "p.toml");
  ASSERT_EQ(piece.heights.size(), 3U);
  EXPECT_EQ(piece.heights[0], Length::millimetres(2));
  EXPECT_EQ(piece.heights[1], Length::millimetres(10));
  EXPECT_EQ(piece.heights[2], Length::millimetres(18));
}

TEST(PieceFile, RefusesWhatContradictsItselfNamingLineAndKey) {
  EXPECT_THAT(message(with(kPiece, "= 15", "= 95")), StartsWith("p.toml:4: half_angle_deg: 95 found"));
  EXPECT_THAT(message(with(kPiece, "= 80", "= 0")), StartsWith("p.toml:5: base_diameter_mm: 0 found"));
  EXPECT_THAT(message(with(kPiece, "height_mm = 20", "height_mm = 160")), HasSubstr("apex at 149.28"));
  EXPECT_THAT(message(with(kPiece, "cone_frustum", "cube")), StartsWith("p.toml:3: kind: \"cube\" found"));
  EXPECT_THAT(message(with(kPiece, "tilt_deg = 10\n", "")), HasSubstr("tilt_deg: missing"));
  EXPECT_THAT(message(with(kPiece, "sense = -1", "sense = 2")), StartsWith("p.toml:14: path.sense: 2 found"));
  EXPECT_THAT(message(with(kPiece, "[2, 10, 18]", "[2, 10, 28]")), HasSubstr("28 found, heights from 0"));
  EXPECT_THAT(message(with(kPiece, "[2, 10, 18]", "[2, 10, 2]")), HasSubstr("2 found twice"));
  EXPECT_THAT(message(with(kPiece, "[2, 10, 18]", "[]")), HasSubstr("a list of one or more heights"));
  EXPECT_THAT(message(with(kPiece, "points = 360", "points = 36.5")), HasSubstr("a whole number"));
  EXPECT_THAT(message(with(kPiece, "overhang_mm = 2", "overhang_mm = 2\ncorner_radius_mm = 11")),
              HasSubstr("corner_radius_mm: 11 found"));
  EXPECT_THAT(message(with(kPiece, "overhang_mm = 2", "overhang_mm = 2\ncorner_radius_mm = 10")),
              HasSubstr("beside the tool's rounded end; an overhang_mm of 7.929"));
  EXPECT_THAT(message(with(kPiece, "tilt_deg = 10\ntilt_azimuth_deg = 90", "tilt_deg = 90\ntilt_azimuth_deg = 0")),
              HasSubstr("along X of W"));
  EXPECT_THAT(message(with(kPiece, "tilt_deg", "tild_deg")), HasSubstr("tilt_deg"));
  EXPECT_THAT(message(with(kPiece, "[tool]", "[tools]")), HasSubstr("tool"));
}

const std::string kTrace = [] {
  std::string text = "# measured\nphi_deg,h_mm,deviation_um\n";
  for (const int h : {18, 2})
    for (int k = 0; k < 36; ++k)
      text += std::to_string(10 * k) + "," + std::to_string(h) + "," + std::to_string(h + 3 * (k % 2)) + "\n";
  return text;
}();

TEST(MeasuredPieceFile, GivesOneTraceAHeight) {
  const TestPiece piece = parse_piece(kPiece, "p.toml");
  const std::vector<ConeTrace> traces = traces_of(parse_measured_piece(kTrace, "t.csv", piece), piece);
  ASSERT_EQ(traces.size(), 2U);
  EXPECT_EQ(traces[0].h_mm, 2);
  EXPECT_NEAR(traces[0].nominal_radius_mm, 40 - 2 * std::tan(piece.cone.half_angle.in_radians()), 1e-12);
  EXPECT_NEAR(traces[1].normal_mm[1], 21e-3, 1e-15);
  EXPECT_NEAR(evaluate_cone(traces, piece.cone.half_angle).heights[0].lsc_mm,
              3e-3 / std::cos(piece.cone.half_angle.in_radians()), 1e-6);
}

TEST(MeasuredPieceFile, RefusesHeightsBeyondThePieceAndOpenTraces) {
  const TestPiece piece = parse_piece(kPiece, "p.toml");
  const auto refused = [&](const std::string& text) -> std::string {
    try {
      parse_measured_piece(text, "t.csv", piece);
    } catch (const InputError& e) {
      return e.what();
    }
    return "nothing was refused";
  };
  EXPECT_THAT(refused("phi_deg,h_mm,deviation_um\n0,25,1\n"), StartsWith("t.csv:2: h_mm: 25 found"));
  EXPECT_THAT(refused("phi_deg,h_mm,deviation_um\n0,2,1\n10,2,1\n20,2,1\n30,2,1\n"), HasSubstr("half a turn"));
  EXPECT_THAT(refused("phi_deg,deviation_um\n0,25\n"), HasSubstr("no column h_mm"));
  EXPECT_THAT(refused("phi_deg,h_mm,deviation_um\n"), HasSubstr("no measured points"));
}

TEST(PredictionFile, CarriesTheColumnsAndKeysOfTheContract) {
  TestPiece piece = usual_piece(15, 10);
  piece.points = 12;
  const SurfaceGrid surface = evaluated_surface(piece);
  PredictedPiece found{.name = "uncompensated", .deviation_mm = std::vector<double>(36, 1e-3)};
  found.evaluation = evaluate_cone(traces_of(piece, surface, found.deviation_mm), piece.cone.half_angle);
  PredictedPiece other = found;
  other.name = "corrected";
  const std::string csv = deviations_text(surface, std::span(&found, 1), 0);
  EXPECT_THAT(csv, StartsWith("phi_deg,h_mm,x_mm,y_mm,z_mm,nx,ny,nz,deviation_um\n0,2,"));
  EXPECT_EQ(std::ranges::count(csv, '\n'), 37);
  EXPECT_THAT(csv, HasSubstr("\n330,18,"));
  const std::vector<PredictedPiece> both = {found, other};
  EXPECT_THAT(deviations_text(surface, both, 1), HasSubstr("deviation_um,uncompensated_um\n"));
  const nlohmann::json j = evaluation_json(piece, surface, found);
  for (const char* key : {"heights", "half_angle_deg", "axis_tilt_urad", "rms_um"}) EXPECT_TRUE(j.contains(key)) << key;
  for (const char* key : {"h_mm", "lsc_um", "mzc_um", "mic_um", "mcc_um", "center_um", "diameter_mm"})
    EXPECT_TRUE(j["heights"][0].contains(key)) << key;
  EXPECT_NEAR(j["rms_um"].get<double>(), 1, 1e-12);
  EXPECT_NEAR(j["half_angle_deg"].get<double>(), 15, 1e-9);
  EXPECT_NEAR(j["form_um"].get<double>(), 0, 1e-9);
}

TEST(RemovedShares, TellWhatIsGoneAndNothingWhereNothingWas) {
  const TestPiece piece = parse_piece(kPiece, "p.toml");
  HeightEvaluation at{.h_mm = 2, .lsc_mm = 4e-3, .center_mm = {3e-3, 4e-3}};
  at.diameter_mm = 2 * radius_at(piece.cone, Length::millimetres(2)).in_millimetres() - 8e-3;
  const ConeEvaluation before{.heights = {at}, .rms_mm = 2e-3};
  at.lsc_mm = 1e-3, at.center_mm = {0, 1e-3}, at.diameter_mm += 10e-3;
  const RemovedShares removed = removed_shares(piece, before, {.heights = {at}, .rms_mm = 3e-3});
  EXPECT_NEAR(*removed.roundness, 0.75, 1e-12);
  EXPECT_NEAR(*removed.position, 0.8, 1e-12);
  EXPECT_NEAR(*removed.size, 0.75, 1e-9);  // 8 um too small became 2 um too large
  EXPECT_NEAR(*removed.rms, -0.5, 1e-12);
  EXPECT_FALSE(removed.form.has_value());
}

}  // namespace
}  // namespace trunnion
