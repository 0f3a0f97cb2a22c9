#include "model/effects/rotary_error_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "error.h"
#include "errormap/fields.h"
#include "errormap/harmonic_surface.h"
#include "model/model.h"
#include "support/noise.h"

namespace trunnion {
namespace {

using nlohmann::json;

const std::vector<Angle> kA = stations_deg({-90, -45.5, 0});
const std::vector<Angle> kC = stations_deg({0, 72.001, 144, 216, 288});

ErrorGrid drawn(std::uint64_t seed) {
  testing::Noise noise(seed);
  ErrorGrid grid = zero_grid(kA, kC);
  Eigen::VectorXd values(static_cast<Eigen::Index>(grid.coefficient_count()));
  for (Eigen::Index k = 0; k < values.size(); ++k) values[k] = (k % 6 < 3 ? 5e-3 : 3e-5) * noise.normal();
  return with_coefficients(grid, values);
}

EffectContext context(const std::string& structure = "w C' A' Y' b X Z t") {
  return effect_context(twin(structure).machine);
}

Situation at(double a, double c, const Eigen::Vector3d& p = {50, -60, 70}) {
  Situation s;
  s.at = degrees(a, c);
  s.point_r_mm = p;
  return s;
}

std::shared_ptr<RotaryErrorMap> written_and_read(const RotaryErrorMap& map, const EffectContext& c = context()) {
  return RotaryErrorMap::read(json::parse(map.to_json().dump()), c);
}

TEST(RotaryErrorMap, NeedsNotVanishAtTheReferenceToGiveAPoseErrorThatDoes) {
  const ErrorGrid grid = drawn(1);
  const RotaryErrorMap map({.grid = grid}, context());
  Twin both = twin("w C' A' Y' b X Z t");
  give_errors(both, [&](IndexedPosition p) { return map.surface().at(p); });
  EXPECT_GT(grid.at_node(2, 0).turn.vector().norm(), 1e-3);
  EXPECT_LT(map.at(at(0, 0)).vector().norm(), 1e-15);
  testing::Noise noise(2);
  for (int k = 0; k < 100; ++k) {
    const Situation s = at(noise.uniform(-90, 0), noise.uniform(0, 360));
    const testing::AxisErrors wanted = both.exact.pose_error(exact_position(both.machine, s.at));
    EXPECT_LT((map.at(s).translation_mm - wanted.translation_mm).norm(), 1e-12);
    EXPECT_LT((map.at(s).rotation_rad - wanted.rotation_rad).norm(), 1e-14);
    EXPECT_LT((map.basis(s) * grid.coefficients() - map.at(s).vector()).norm(), 1e-5);  // to first order
  }
}

TEST(RotaryErrorMap, ReadsBackWhatItWrites) {
  const auto n = static_cast<Eigen::Index>(drawn(3).coefficient_count());
  RotaryMapContent content{.grid = drawn(3)};
  content.interpolation = Interpolation::bilinear;
  content.interpolation_sigma_mm = 1e-4, content.interpolation_sigma_rad = 2e-6;
  content.grid_covariance = Eigen::VectorXd::LinSpaced(n, 1e-10, 9e-10).asDiagonal();
  const RotaryErrorMap map(content, context());
  const auto read = written_and_read(map);
  EXPECT_LT((read->content().grid.coefficients() - content.grid.coefficients()).norm(), 1e-17);
  EXPECT_EQ(read->content().grid.a_stations, kA);
  EXPECT_EQ(read->content().grid.c_stations, kC);
  EXPECT_EQ(read->content().interpolation, Interpolation::bilinear);
  EXPECT_NEAR(read->content().interpolation_sigma_rad, 2e-6, 1e-20);
  EXPECT_LT((read->content().grid_covariance - content.grid_covariance).norm(), 1e-22);
  EXPECT_LT((read->covariance_at(at(-20, 33)) - map.covariance_at(at(-20, 33))).norm(), 1e-20);
  EXPECT_EQ(read->to_json(), map.to_json());
}

TEST(RotaryErrorMap, ReadsBackItsWholeCovariance) {
  const auto n = static_cast<Eigen::Index>(drawn(4).coefficient_count());
  testing::Noise noise(5);
  Eigen::MatrixXd root(n, n);
  for (Eigen::Index k = 0; k < root.size(); ++k) root.data()[k] = (k % n % 6 < 3 ? 1e-5 : 1e-7) * noise.normal();
  RotaryMapContent content{.grid = drawn(4), .grid_covariance = root * root.transpose(), .full_covariance = true};
  const auto read = written_and_read(RotaryErrorMap(content, context()));
  EXPECT_TRUE(read->content().full_covariance);
  const Eigen::MatrixXd difference = read->content().grid_covariance - content.grid_covariance;
  for (Eigen::Index r = 0; r < n; ++r)
    for (Eigen::Index c = 0; c < n; ++c)  // seven digits
      ASSERT_LE(std::abs(difference(r, c)), 6e-7 * std::abs(content.grid_covariance(r, c)));
}

TEST(RotaryErrorMap, WritesStandardUncertaintiesAloneWhereCovariancesWouldFillAFile) {
  std::vector<Angle> tilts, turns;
  for (int k = 0; k < 10; ++k) tilts.push_back(Angle::degrees(-90 + 10 * k));
  for (int k = 0; k < 72; ++k) turns.push_back(Angle::degrees(5 * k));
  RotaryMapContent content{.grid = zero_grid(tilts, turns), .full_covariance = true};
  const auto n = static_cast<Eigen::Index>(content.grid.coefficient_count());
  content.grid_covariance = Eigen::MatrixXd::Constant(n, n, 1e-12);
  content.grid_covariance.diagonal().setConstant(4e-12);
  const json j = RotaryErrorMap(content, context()).to_json();
  EXPECT_FALSE(j.contains("covariance"));
  EXPECT_NEAR(j["std"]["EXA"]["data"][3].get<double>(), 2e-3, 1e-12);
}

TEST(RotaryErrorMap, WhatNothingDeterminedIsNullAndNotUsedUnasked) {
  RotaryMapContent content{.grid = drawn(6)};
  content.unseen.assign(content.grid.coefficient_count(), false);
  content.unseen[content.grid.turn_offset(1, 2)] = true;
  const RotaryErrorMap map(content, context());
  const json j = map.to_json();
  EXPECT_TRUE(j["values"]["EXC"]["data"][1][2].is_null());
  const auto read = written_and_read(map);
  EXPECT_EQ(read->content().unseen, content.unseen);
  EXPECT_EQ(read->unseen_freedoms(), std::vector<std::string>{"EXC at A -45.5 C 144"});
  EXPECT_THROW(read->at(at(-10, 10)), RangeError);
  EXPECT_THROW(read->basis(at(-10, 10)), RangeError);
}

TEST(RotaryErrorMap, ReadsBackASmoothSurface) {
  RotaryMapContent content{.grid = drawn(7)};
  content.smooth_basis = HarmonicBasis{{kA.front(), kA.back()}, 3, 2, 2};
  content.smooth_method = "structured";
  const Eigen::Index n = content.smooth_basis->coefficient_count();
  content.smooth_coefficients = Eigen::VectorXd::LinSpaced(n, -3e-5, 4e-5);
  content.smooth_covariance = Eigen::VectorXd::Constant(n, 1e-12).asDiagonal();
  const RotaryErrorMap map(content, context());
  const auto read = written_and_read(map);
  EXPECT_EQ(read->content().smooth_basis, content.smooth_basis);
  EXPECT_EQ(read->content().smooth_method, "structured");
  for (const double c : {0., 100., 333.}) {
    EXPECT_LT((read->at(at(-33, c)) - map.at(at(-33, c))).vector().norm(), 1e-17);
    EXPECT_LT((read->covariance_at(at(-33, c)) - map.covariance_at(at(-33, c))).norm(), 1e-19);
  }
}

TEST(RotaryErrorMap, SpeaksOfBOnABMachine) {
  const EffectContext b = context("w C' B' X' b Y Z t");
  const RotaryErrorMap map({.grid = drawn(8)}, b);
  const json j = map.to_json();
  EXPECT_TRUE(j["grid_deg"].contains("B"));
  EXPECT_TRUE(j["values"].contains("EBB"));
  EXPECT_EQ(written_and_read(map, b)->content().grid.tilt.size(), 3U);
}

TEST(RotaryErrorMap, SaysWhatIsWrongWithAFile) {
  const json good = RotaryErrorMap({.grid = drawn(9)}, context()).to_json();
  const auto message = [&](auto spoil) -> std::string {
    json j = good;
    spoil(j);
    try {
      RotaryErrorMap::read(j, context());
    } catch (const ModelError& error) {
      return error.what();
    }
    return "taken";
  };
  EXPECT_EQ(message([](json&) {}), "taken");
  EXPECT_EQ(message([](json& j) { j.erase("values"); }), "rotary_error_map: \"values\" is missing");
  EXPECT_EQ(message([](json& j) { j["grid_deg"].erase("A"); }), "rotary_error_map: grid_deg: \"A\" is missing");
  EXPECT_EQ(message([](json& j) { j["grid_deg"]["B"] = {0}; }),
            "rotary_error_map: grid_deg.B: the machine's rotary axes are A and C");
  EXPECT_EQ(message([](json& j) { j["grid_deg"]["A"] = json::array(); }),
            "rotary_error_map: grid_deg.A: a list of angles is wanted");
  EXPECT_EQ(message([](json& j) {
              j["grid_deg"]["A"] = {-90, "x", 0};
            }),
            "rotary_error_map: grid_deg.A: \"x\" found, a number is wanted");
  EXPECT_EQ(message([](json& j) {
              j["grid_deg"]["A"] = {0, -45, -90};
            }),
            "error map: the A stations must ascend strictly");
  EXPECT_EQ(message([](json& j) {
              j["grid_deg"]["A"] = {-90, -45, -10};
            }),
            "rotary_error_map: its tilt stations do not reach the reference pose 0, where the workpiece is set up");
  EXPECT_EQ(message([](json& j) { j["values"].erase("EBC"); }), "rotary_error_map: values: \"EBC\" is missing");
  EXPECT_EQ(message([](json& j) { j["values"]["EXD"] = 1; }), "rotary_error_map: values.EXD: not an error of this map");
  EXPECT_EQ(message([](json& j) { j["values"]["EXA"]["unit"] = "mm"; }),
            "rotary_error_map: values.EXA.unit: \"mm\" found, \"um\" is wanted");
  EXPECT_EQ(message([](json& j) { j["values"]["EXA"]["data"].push_back(1); }),
            "rotary_error_map: values.EXA.data: 4 rows found, 3 (one per A) are wanted");
  EXPECT_EQ(message([](json& j) { j["values"]["ECC"]["data"][1].push_back(1); }),
            "rotary_error_map: values.ECC.data[1]: 6 values found, 5 (one per C) are wanted");
  EXPECT_EQ(message([](json& j) { j["values"]["ECC"]["data"][1][2] = "high"; }),
            "rotary_error_map: values.ECC.data: \"high\" found, a number is wanted");
  EXPECT_EQ(message([](json& j) {
              j["covariance"] = {1, 2};
            }),
            "rotary_error_map: covariance: a lower triangle of 5886 numbers is wanted");
  EXPECT_EQ(message([](json& j) { j["std"] = j["values"], j["std"]["EXA"]["data"][0] = -1; }),
            "rotary_error_map: std: a negative standard uncertainty");
  EXPECT_EQ(message([](json& j) { j["interpolation"]["method"] = "spline"; }),
            "rotary_error_map: interpolation.method: \"spline\" found, one of trig-cubic, bilinear, natural-neighbour, "
            "structured, gaussian-process is wanted");
}

TEST(RotaryErrorMap, TakesOtherParametersLikeAnyEffect) {
  const auto refuses = [](const Effect& effect) {
    const auto n = static_cast<Eigen::Index>(effect.parameters().size());
    EXPECT_THROW(effect.with_parameters(Eigen::VectorXd::Zero(n - 1), {}), ModelError);
    EXPECT_THROW(effect.with_parameters(Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Identity(n - 1, n - 1)), ModelError);
  };
  const RotaryErrorMap nodes({.grid = drawn(5)}, context());
  const ErrorGrid wanted = drawn(6);
  const Eigen::MatrixXd covariance = 1e-12 * Eigen::MatrixXd::Identity(nodes.values().size(), nodes.values().size());
  const EffectPtr other = nodes.with_parameters(wanted.coefficients(), covariance);
  const RotaryErrorMap direct({.grid = wanted, .grid_covariance = covariance, .full_covariance = true}, context());
  EXPECT_EQ(other->to_json(), direct.to_json());
  EXPECT_EQ(other->at(at(-30, 200)).vector(), direct.at(at(-30, 200)).vector());
  EXPECT_EQ(other->covariance_at(at(-30, 200)), direct.covariance_at(at(-30, 200)));
  EXPECT_EQ(other->parameters()[0].name, "EXA at A -90");
  EXPECT_EQ(other->parameters().back().name, "ECC at A 0 C 288");
  EXPECT_NE(nodes.at(at(-30, 200)).vector(), direct.at(at(-30, 200)).vector());
  refuses(nodes);

  const HarmonicBasis basis{.a_range = {kA.front(), kA.back()}, .tilt_degree = 2, .harmonics = 2, .turn_degree = 1};
  testing::Noise noise(7);
  const auto draw = [&] {
    Eigen::VectorXd v(basis.coefficient_count());
    for (Eigen::Index k = 0; k < v.size(); ++k) v[k] = (k % 6 < 3 ? 5e-3 : 3e-5) * noise.normal();
    return v;
  };
  const Eigen::VectorXd before = draw(), after = draw();
  const Eigen::MatrixXd known = 1e-12 * Eigen::MatrixXd::Identity(before.size(), before.size());
  const RotaryErrorMap smooth(
      {.grid = drawn(8), .smooth_basis = basis, .smooth_method = "structured", .smooth_coefficients = before},
      context());
  const EffectPtr moved = smooth.with_parameters(after, known);
  EXPECT_EQ(moved->at(at(-30, 200)).vector(),
            RotaryErrorMap({.grid = drawn(8), .smooth_basis = basis, .smooth_coefficients = after}, context())
                .at(at(-30, 200))
                .vector());
  const EffectPtr read = RotaryErrorMap::read(json::parse(moved->to_json().dump()), context());
  EXPECT_LT((read->values() - after).norm(), 1e-15);
  EXPECT_LT((read->covariance_at(at(-60, 10)) - moved->covariance_at(at(-60, 10))).norm(), 1e-18);
  // The values at the nodes follow.
  const auto& found = dynamic_cast<const RotaryErrorMap&>(*moved);
  const RotaryErrors change_at = [&] {
    const HarmonicSurface a(basis, before), b(basis, after);
    const IndexedPosition p{kA[1], kC[3]};
    return RotaryErrors{PoseError::from_vector(b.at(p).tilt.vector() - a.at(p).tilt.vector()),
                        PoseError::from_vector(b.at(p).turn.vector() - a.at(p).turn.vector())};
  }();
  const RotaryErrors old_node = drawn(8).at_node(1, 3), new_node = found.content().grid.at_node(1, 3);
  EXPECT_LT((new_node.tilt.vector() - old_node.tilt.vector() - change_at.tilt.vector()).norm(), 1e-15);
  EXPECT_LT((new_node.turn.vector() - old_node.turn.vector() - change_at.turn.vector()).norm(), 1e-15);
  // The functions' names are those of the surface: one at a time, each is where it says.
  for (std::size_t k = 0; k < found.parameters().size(); ++k) {
    const std::string& name = found.parameters()[k].name;
    const auto i = static_cast<Eigen::Index>(k);
    const Eigen::Matrix<double, 12, Eigen::Dynamic> b = found.surface().jacobian(degrees(-20, 33));
    const double a_rad = degrees(-20, 0).a.in_radians(), c_rad = degrees(0, 33).c.in_radians();
    const Eigen::Index row = k % 6 + (name[2] == 'C' ? 6 : 0);
    double expected = std::nan("");
    const std::string function = name.substr(4);
    if (function == "mean" || function == "P0") expected = 1;
    if (function == "P1") expected = -20 / 45.0 + 1;
    if (function == "cos1:0") expected = std::cos(c_rad);
    if (function == "sin2:1") expected = std::sin(2 * c_rad) * std::sin(a_rad);
    if (!std::isnan(expected)) {
      EXPECT_NEAR(b(row, i), expected, 1e-14) << name;
    }
  }
  refuses(smooth);
}

}  // namespace
}  // namespace trunnion
