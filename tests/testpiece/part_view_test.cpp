#include "testpiece/part_view.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>

#include "testpiece/colour_bar.h"
#include "testpiece/colour_scale.h"
#include "testpiece/pieces.h"
#include "testpiece/plots.h"

namespace trunnion {
namespace {

using ::testing::HasSubstr;

constexpr double kEnd_um = 5;  // of the colour scale

std::uint32_t word(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, 4);
  return value;
}

struct Scene {
  TestPiece piece = usual_piece(15, 10);
  SurfaceGrid surface;
  std::vector<double> deviation;
  Scene() {
    piece.points = 36;
    piece.heights = {Length(), Length::millimetres(10), Length::millimetres(20)};
    surface = evaluated_surface(piece);
    for (std::size_t i = 0; i < surface.points.size(); ++i)
      deviation.push_back(4e-3 * std::sin(static_cast<double>(i)));
  }
};

TEST(PartView, IsAGlbWhoseChunksAndAccessorsAddUp) {
  const Scene scene;
  const std::string glb = part_glb(scene.piece, scene.surface, scene.deviation, kEnd_um);
  ASSERT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_EQ(word(glb, 4), 2U);
  EXPECT_EQ(word(glb, 8), glb.size());
  const std::size_t text = word(glb, 12);
  EXPECT_EQ(text % 4, 0U);
  EXPECT_EQ(glb.substr(16, 4), "JSON");
  const auto gltf = nlohmann::json::parse(glb.substr(20, text));
  const std::size_t binary = word(glb, 20 + text);
  EXPECT_EQ(28 + text + binary, glb.size());
  EXPECT_EQ(glb.substr(24 + text, 4), std::string("BIN\0", 4));
  EXPECT_LE(gltf["buffers"][0]["byteLength"].get<std::size_t>(), binary);
  std::size_t end = 0;
  for (const auto& view : gltf["bufferViews"]) {
    EXPECT_EQ(view["byteOffset"].get<std::size_t>(), end);
    end += view["byteLength"].get<std::size_t>();
  }
  EXPECT_EQ(end, gltf["buffers"][0]["byteLength"].get<std::size_t>());
  for (const auto& mesh : gltf["meshes"]) {
    const auto& primitive = mesh["primitives"][0];
    const auto& accessors = gltf["accessors"];
    const auto& triangles = accessors[primitive["indices"].get<std::size_t>()];
    const std::size_t vertices = accessors[primitive["attributes"]["POSITION"].get<std::size_t>()]["count"];
    const std::size_t offset = gltf["bufferViews"][triangles["bufferView"].get<std::size_t>()]["byteOffset"];
    for (std::size_t i = 0; i < triangles["count"]; ++i) ASSERT_LT(word(glb, 28 + text + offset + 4 * i), vertices);
  }
  EXPECT_EQ(gltf["asset"]["extras"]["scale_um"], kEnd_um);
}

/// Signed volume of the mesh, mm^3: positive only if it is closed well enough and every triangle faces outward.
double volume_mm3(const std::string& glb) {
  const std::size_t text = word(glb, 12), start = 28 + text;
  const auto gltf = nlohmann::json::parse(glb.substr(20, text));
  const auto vertex = [&](std::size_t i) -> Eigen::Vector3d {
    float v[3];
    std::memcpy(v, glb.data() + start + 12 * i, 12);
    return Eigen::Vector3d(v[0], v[1], v[2]) * 1e3;
  };
  double six = 0;
  const std::size_t indices = gltf["accessors"][3]["count"], offset = gltf["bufferViews"][3]["byteOffset"];
  for (std::size_t i = 0; i < indices; i += 3) {
    const auto at = [&](std::size_t k) -> Eigen::Vector3d { return vertex(word(glb, start + offset + 4 * (i + k))); };
    six += at(0).dot(at(1).cross(at(2)));
  }
  return six / 6;
}

TEST(PartView, EnclosesTheFrustumsVolumeFacingOutward) {
  Scene scene;
  scene.piece.points = 180;
  scene.surface = evaluated_surface(scene.piece);
  const std::vector<double> flat(scene.surface.points.size(), 0);
  const double r = 40, top = 40 - 20 * std::tan(15 * std::numbers::pi / 180);
  const double exact = std::numbers::pi * 20 / 3 * (r * r + r * top + top * top);
  EXPECT_NEAR(volume_mm3(part_glb(scene.piece, scene.surface, flat, kEnd_um)) / exact, 1, 1e-3);
  // Magnified by 1000, 10 um more all round are 10 mm of normal.
  const std::vector<double> thick(scene.surface.points.size(), 10e-3);
  EXPECT_GT(volume_mm3(part_glb(scene.piece, scene.surface, thick, kEnd_um, 1000)), 1.2 * exact);
}

TEST(ColourBar, WritesItsEndsInUmAndTheMagnification) {
  const Mesh plain = colour_bar(20, 0, {100, -5, 0}, 60), magnified = colour_bar(20, 500, {100, -5, 0}, 60);
  EXPECT_GT(magnified.index.size(), plain.index.size());
  // Both ends of the scale stand where they belong, in metres with Y up.
  const auto height_of = [&](Colour c) {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < plain.position.size(); ++i)
      if (plain.colour[i][0] == c[0] && plain.colour[i][1] == c[1] && plain.colour[i][2] == c[2])
        sum += plain.position[i][1], ++count;
    EXPECT_GT(count, 0);
    return sum / count;
  };
  EXPECT_LT(height_of(deviation_colour(1.0 / 64 - 1)), 2e-3);
  EXPECT_GT(height_of(deviation_colour(1 - 1.0 / 64)), 58e-3);
  for (const auto& p : plain.position) {
    EXPECT_NEAR(p[2], 5e-3, 1e-7);  // upright in a plane of W's Y
    EXPECT_GT(p[0], 99.99e-3);
  }
  // Every triangle faces -Y of W, which is +Z of glTF.
  for (std::size_t i = 0; i < magnified.index.size(); i += 3) {
    const auto at = [&](std::size_t k) { return magnified.position[magnified.index[i + k]]; };
    const double x1 = at(1)[0] - at(0)[0], y1 = at(1)[1] - at(0)[1], x2 = at(2)[0] - at(0)[0], y2 = at(2)[1] - at(0)[1];
    EXPECT_GT(x1 * y2 - x2 * y1, 0) << i;
  }
  for (const char letter : std::string("0123456789+-.eumx")) EXPECT_FALSE(strokes_of(letter).empty()) << letter;
}

TEST(ColourScale, IsNeutralInTheMiddleAndHoldsItsEnds) {
  EXPECT_EQ(deviation_colour(0), (Colour{247, 247, 247}));
  EXPECT_EQ(deviation_colour(7), deviation_colour(1));
  EXPECT_EQ(deviation_colour(-7), deviation_colour(-1));
  EXPECT_GT(deviation_colour(0.9)[0], deviation_colour(0.9)[2]);  // left material is red
  EXPECT_LT(deviation_colour(-0.9)[0], deviation_colour(-0.9)[2]);
  EXPECT_EQ(round_scale(3.1), 5);
  EXPECT_EQ(round_scale(0.02), 0.02);
  EXPECT_EQ(round_scale(60), 100);
  EXPECT_EQ(round_scale(0), 1);
  EXPECT_EQ(round_scale(3e-7), 1);  // rounding is no deviation
}

TEST(Plots, SayWhatTheyShow) {
  Scene scene;
  const std::vector<ConeTrace> traces = traces_of(scene.piece, scene.surface, scene.deviation);
  const PolarCurve curves[] = {{"h 0 mm <a>", radial_trace(traces[0], scene.piece.cone.half_angle)},
                               {"h 20 mm", radial_trace(traces[2], scene.piece.cone.half_angle)}};
  const std::string polar = polar_plot_svg("Roundness & more", curves);
  EXPECT_THAT(polar, HasSubstr("Roundness &amp; more"));
  EXPECT_THAT(polar, HasSubstr("h 0 mm &lt;a&gt;: LSC 8."));
  EXPECT_THAT(polar, HasSubstr("1 division = 2.5 µm"));
  const std::string map = unrolled_map_svg("Deviation", 36, scene.surface.h_mm, scene.deviation, kEnd_um);
  EXPECT_THAT(map, HasSubstr("+5 µm"));
  EXPECT_THAT(map, HasSubstr("</svg>"));
  for (const std::string* svg : {&polar, &map}) {
    EXPECT_EQ(svg->find("nan"), std::string::npos);
    EXPECT_EQ(std::ranges::count(*svg, '<'), std::ranges::count(*svg, '>'));
  }
}

}  // namespace
}  // namespace trunnion
