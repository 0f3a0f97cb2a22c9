#include <gtest/gtest.h>

#include <cmath>

#include "error.h"
#include "errormap/fields.h"
#include "errormap/harmonic_surface.h"
#include "support/noise.h"

namespace trunnion {
namespace {

constexpr double kRounding = 1e-15;  // mm and rad, far below any probe

const std::vector<Angle> kProbedA = stations_deg({-90, -60, -30, 0});
const std::vector<Angle> kProbedC = stations_deg({0, 60, 120, 180, 240, 300});
const std::vector<Angle> kUnevenA = stations_deg({-100, -77, -30, -11, 5, 30});
const std::vector<Angle> kUnevenC = stations_deg({3, 50, 130, 190, 222, 260, 301});

ErrorGrid drawn_grid(std::uint64_t seed, const std::vector<Angle>& a, const std::vector<Angle>& c) {
  testing::Noise noise(seed);
  ErrorGrid grid = zero_grid(a, c);
  Eigen::VectorXd values(static_cast<Eigen::Index>(grid.coefficient_count()));
  for (Eigen::Index k = 0; k < values.size(); ++k) values[k] = (k % 6 < 3 ? 5e-3 : 3e-5) * noise.normal();
  return with_coefficients(grid, values);
}

std::vector<Interpolation> all_methods() {
  return {Interpolation::trig_cubic, Interpolation::bilinear, Interpolation::natural_neighbour};
}

TEST(ErrorSurface, TrigonometricTimesCubicReproducesABandLimitedFieldCubicInTheTilt) {
  for (const auto& [a, c] : {std::pair(kProbedA, kProbedC), std::pair(kUnevenA, kUnevenC),
                             std::pair(kProbedA, stations_deg({10, 60, 120, 200, 240, 300, 333, 359}))}) {
    const auto surface = make_surface(Interpolation::trig_cubic, sampled(band_limited, a, c));
    testing::Noise noise(1);
    for (int k = 0; k < 300; ++k) {
      const IndexedPosition at = {Angle::radians(noise.uniform(a.front().in_radians(), a.back().in_radians())),
                                  Angle::degrees(noise.uniform(-720, 720))};
      EXPECT_LT(difference(surface->at(at), band_limited(at)), kRounding) << at.a.in_degrees() << at.c.in_degrees();
    }
  }
}

TEST(ErrorSurface, SixTurnsCarryTheCosineOfTheThirdHarmonicAndNotItsSine) {
  const auto third = [](IndexedPosition at) {
    RotaryErrors e;
    e.turn.translation_mm = {std::cos(3 * at.c.in_radians()), std::sin(3 * at.c.in_radians()), 0};
    return e;
  };
  const auto surface = make_surface(Interpolation::trig_cubic, sampled(third, kProbedA, kProbedC));
  for (double c = 0; c < 360; c += 7) {
    const Eigen::Vector3d found = surface->at(degrees(-40, c)).turn.translation_mm;
    EXPECT_NEAR(found.x(), std::cos(Angle::degrees(3 * c).in_radians()), 1e-13);
    EXPECT_NEAR(found.y(), 0, 1e-13);
  }
}

TEST(ErrorSurface, AnyStationsOfCDetermineTheTrigonometricInterpolant) {
  // An even number that is not spread over the turn: the last harmonic's phase must not miss them.
  for (const auto& c : {stations_deg({0, 90}), stations_deg({0, 180}), stations_deg({0, 45, 90, 135}),
                        stations_deg({0, 30, 90, 180}), stations_deg({15})}) {
    const ErrorGrid grid = drawn_grid(2, kProbedA, c);
    const auto surface = make_surface(Interpolation::trig_cubic, grid);
    for (std::size_t i = 0; i < kProbedA.size(); ++i)
      for (std::size_t j = 0; j < c.size(); ++j)
        EXPECT_LT(difference(surface->at({kProbedA[i], c[j]}), grid.at_node(i, j)), 1e-14) << c.size() << " " << j;
  }
}

TEST(ErrorSurface, BilinearReproducesABilinearFieldBetweenUnevenStations) {
  const auto field = [](IndexedPosition at) {
    const double a = at.a.in_radians(), c = at.c.in_radians();
    RotaryErrors e;
    e.tilt.translation_mm = {0.010 * a, 0.002, 0};
    e.turn.translation_mm = {0.010 * a, -0.004 * c, 0.003 + 0.002 * a * c};
    return e;
  };
  const auto surface = make_surface(Interpolation::bilinear, sampled(field, kUnevenA, kUnevenC));
  for (double a = -100; a <= 30; a += 6.5)
    for (double c = 3; c <= 301; c += 14.9)
      EXPECT_LT(difference(surface->at(degrees(a, c)), field(degrees(a, c))), 1e-15) << a << " " << c;
  // Past the last station on to the first, a turn later.
  const RotaryErrors at_last = surface->at(degrees(0, 301)), at_first = surface->at(degrees(0, 3));
  const RotaryErrors between = surface->at(degrees(0, 332));
  EXPECT_LT((stacked(between) - 0.5 * (stacked(at_last) + stacked(at_first))).norm(), 1e-15);
}

TEST(ErrorSurface, PassesThroughItsNodesWhateverTheTurn) {
  for (const auto& [a, c] : {std::pair(kProbedA, kProbedC), std::pair(kUnevenA, kUnevenC)})
    for (const Interpolation method : all_methods()) {
      const ErrorGrid grid = drawn_grid(3, a, c);
      const auto surface = make_surface(method, grid);
      for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < c.size(); ++j)
          for (const double turn : {-720., 0., 360.})
            EXPECT_LT(difference(surface->at({a[i], c[j] + Angle::degrees(turn)}), grid.at_node(i, j)), 1e-14)
                << interpolation_name(method);
    }
}

TEST(ErrorSurface, CrossesTheSeamOfCWithoutAStep) {
  for (const Interpolation method : all_methods()) {
    const auto surface = make_surface(method, drawn_grid(4, kProbedA, kProbedC));
    for (double a = -90; a <= 0; a += 4.5) {
      constexpr double kStep_deg = 1e-7;  // times a slope of 1e-4 mm/deg: 1e-11 mm
      const RotaryErrors left = surface->at(degrees(a, 360 - kStep_deg)), right = surface->at(degrees(a, kStep_deg));
      EXPECT_LT(difference(left, right), 1e-9) << interpolation_name(method);
      EXPECT_LT(difference(surface->at(degrees(a, 0)), surface->at(degrees(a, 360))), 1e-14);
      EXPECT_LT(difference(surface->at(degrees(a, -123)), surface->at(degrees(a, 237))), 1e-14);
    }
  }
}

TEST(ErrorSurface, CrossesTheSeamAndEveryStationOfCWithoutAKink) {
  for (const Interpolation method : {Interpolation::trig_cubic, Interpolation::natural_neighbour}) {
    const auto surface = make_surface(method, drawn_grid(5, kProbedA, kProbedC));
    for (double a = -85; a < 0; a += 7.5)
      for (const double c : {0., 30., 60., 180., 300., 359.}) {
        constexpr double kStep_deg = 1e-3;
        const auto value = [&](double offset) { return stacked(surface->at(degrees(a, c + offset))); };
        const Eigen::Matrix<double, 12, 1> left = (value(0) - value(-kStep_deg)) / kStep_deg;
        const Eigen::Matrix<double, 12, 1> right = (value(kStep_deg) - value(0)) / kStep_deg;
        EXPECT_LT((left - right).cwiseAbs().maxCoeff(), 1e-6) << interpolation_name(method) << a << " " << c;
      }
  }
}

TEST(ErrorSurface, ItsJacobianIsItsDependenceOnTheNodes) {
  for (const Interpolation method : all_methods()) {
    const ErrorGrid grid = drawn_grid(6, kProbedA, kUnevenC);
    const auto surface = make_surface(method, grid);
    const Eigen::VectorXd theta = grid.coefficients();
    ASSERT_EQ(surface->coefficient_count(), theta.size());
    testing::Noise noise(7);
    for (int k = 0; k < 40; ++k) {
      const IndexedPosition at = degrees(noise.uniform(-90, 0), noise.uniform(-400, 400));
      EXPECT_LT((surface->jacobian(at) * theta - stacked(surface->at(at))).norm(), 1e-15) << interpolation_name(method);
    }
  }
}

TEST(ErrorSurface, AConstantStaysAConstant) {
  const auto constant = [](IndexedPosition) {
    return RotaryErrors{um_urad(1, 2, 3, 4, 5, 6), um_urad(-7, 8, -9, 10, -11, 12)};
  };
  for (const Interpolation method : all_methods())
    for (const auto& a : {kProbedA, stations_deg({-90, -40, 0}), stations_deg({-90, 0}), stations_deg({0})}) {
      const auto surface = make_surface(method, sampled(constant, a, kProbedC));
      for (double at = a.front().in_degrees(); at <= 0; at += 4.5)
        for (double c = 0; c < 360; c += 13)
          EXPECT_LT(difference(surface->at(degrees(at, c)), constant({})), 1e-16) << interpolation_name(method);
    }
}

TEST(ErrorSurface, TheCubicIsNaturalForThreeStationsAndALineForTwo) {
  const auto line = [](IndexedPosition at) {
    RotaryErrors e;
    e.tilt.translation_mm = {0.01 * at.a.in_radians(), 0, 0};
    return e;
  };
  for (const auto& a : {stations_deg({-90, -50, 0}), stations_deg({-90, 0})}) {
    const auto surface = make_surface(Interpolation::trig_cubic, sampled(line, a, kProbedC));
    for (double at = -90; at <= 0; at += 7)
      EXPECT_LT(difference(surface->at(degrees(at, 10)), line(degrees(at, 10))), 1e-16);
  }
}

TEST(ErrorSurface, RefusesATiltOutsideItsStations) {
  for (const Interpolation method : all_methods()) {
    const auto surface = make_surface(method, drawn_grid(8, kProbedA, kProbedC));
    EXPECT_TRUE(surface->covers(Angle::degrees(-90)));
    EXPECT_TRUE(surface->covers(Angle::degrees(1e-10)));
    EXPECT_FALSE(surface->covers(Angle::degrees(0.001)));
    EXPECT_NO_THROW(surface->at(degrees(0.4, 0)));  // a command's own correction may leave the range
    EXPECT_THROW(surface->at(degrees(1, 0)), RangeError);
    EXPECT_THROW(surface->jacobian(degrees(1, 0)), RangeError);
    EXPECT_THROW(surface->at({Angle::radians(std::nan("")), Angle()}), RangeError);
    try {
      surface->at(degrees(-90.75, 0));
      FAIL();
    } catch (const RangeError& error) {
      EXPECT_STREQ(error.what(), "tilt -90.75 deg lies outside the probed range -90 .. 0 deg");
    }
  }
}

TEST(ErrorSurface, RefusesContradictoryGrids) {
  const auto message = [](const ErrorGrid& grid) -> std::string {
    try {
      make_surface(Interpolation::trig_cubic, grid);
    } catch (const ModelError& error) {
      return error.what();
    }
    return "taken";
  };
  EXPECT_EQ(message(zero_grid({}, kProbedC)), "error map: no A stations");
  EXPECT_EQ(message(zero_grid(kProbedA, {})), "error map: no C stations");
  EXPECT_EQ(message(zero_grid(stations_deg({0, 0}), kProbedC)), "error map: the A stations must ascend strictly");
  EXPECT_EQ(message(zero_grid(kProbedA, stations_deg({10, 0}))), "error map: the C stations must ascend strictly");
  EXPECT_EQ(message(zero_grid(kProbedA, stations_deg({0, 180, 360}))),
            "error map: the C stations span a full turn or more; the first is not to be repeated at 360 deg");
  ErrorGrid short_of_one = zero_grid(kProbedA, kProbedC);
  short_of_one.turn.pop_back();
  EXPECT_EQ(message(short_of_one), "error map: the number of errors does not match the stations");
}

TEST(ErrorSurface, MethodsHaveNamesThatReadBack) {
  for (const Interpolation method : all_methods())
    EXPECT_EQ(interpolation_from_name(interpolation_name(method)), method);
  EXPECT_EQ(interpolation_from_name("natural-neighbour"), Interpolation::natural_neighbour);
  EXPECT_EQ(interpolation_from_name("cubic"), std::nullopt);
}

TEST(HarmonicSurface, IsItsJacobianTimesItsCoefficients) {
  for (int turn_degree = 0; turn_degree <= 2; ++turn_degree) {
    const HarmonicBasis basis{{Angle::degrees(-90), Angle::degrees(10)}, 3, 2, turn_degree};
    testing::Noise noise(9);
    Eigen::VectorXd theta(basis.coefficient_count());
    for (Eigen::Index k = 0; k < theta.size(); ++k) theta[k] = 1e-3 * noise.normal();
    const HarmonicSurface surface(basis, theta);
    for (int k = 0; k < 40; ++k) {
      const IndexedPosition at = degrees(noise.uniform(-90, 10), noise.uniform(-400, 400));
      EXPECT_LT((surface.jacobian(at) * theta - stacked(surface.at(at))).norm(), 1e-16);
      EXPECT_LT(difference(surface.at(at), surface.at({at.a, at.c + kFullTurn})), 1e-15);
    }
    EXPECT_THROW(surface.at(degrees(11, 0)), RangeError);
  }
}

TEST(HarmonicSurface, HoldsWhatTheTiltMakesOfAnErrorThatStandsStill) {
  // cos(c) (0.3 + 0.2 sin a + 0.1 (1 - cos a)) in EXC, Legendre P2 in EAA.
  const HarmonicBasis basis{{Angle::degrees(-90), Angle::degrees(0)}, 2, 1, 2};
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(basis.coefficient_count());
  theta[6 * 2 + 3] = 1;
  theta[6 * (3 + 1)] = .3, theta[6 * (3 + 2)] = .2, theta[6 * (3 + 3)] = .1;
  const HarmonicSurface surface(basis, theta);
  const double a = Angle::degrees(-67.5).in_radians(), c = Angle::degrees(50).in_radians();
  const RotaryErrors found = surface.at(degrees(-67.5, 50));
  EXPECT_NEAR(found.turn.translation_mm.x(), std::cos(c) * (.3 + .2 * std::sin(a) + .1 * (1 - std::cos(a))), 1e-15);
  EXPECT_NEAR(found.tilt.rotation_rad.x(), (3 * .25 - 1) / 2, 1e-15);  // scaled to -0.5
}

TEST(HarmonicSurface, HasFiveFunctionsOfTheTiltAtMost) {
  const HarmonicBasis richest{
      .a_range = {Angle::degrees(-90), Angle()}, .tilt_degree = 2, .harmonics = 1, .turn_degree = 4};
  const double a = -0.7, c = 0.4;
  const Eigen::VectorXd values = richest.turn_values({Angle::radians(a), Angle::radians(c)});
  ASSERT_EQ(values.size(), 11);
  EXPECT_NEAR(values[4], std::cos(c) * std::sin(2 * a), kRounding);
  EXPECT_NEAR(values[10], std::sin(c) * (1 - std::cos(2 * a)), kRounding);
  HarmonicBasis beyond = richest;
  beyond.turn_degree = 5;
  EXPECT_THROW(HarmonicSurface(beyond, Eigen::VectorXd::Zero(beyond.coefficient_count())), ModelError);
}

TEST(HarmonicSurface, RefusesTheWrongNumberOfCoefficients) {
  const HarmonicBasis basis{{Angle::degrees(-90), Angle::degrees(0)}, 2, 1, 0};
  EXPECT_THROW(HarmonicSurface(basis, Eigen::VectorXd::Zero(3)), ModelError);
}

}  // namespace
}  // namespace trunnion
