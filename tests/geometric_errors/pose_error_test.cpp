#include "geometric_errors/pose_error.h"

#include <gtest/gtest.h>

#include "support/noise.h"
#include "support/twin.h"

namespace trunnion {
namespace {

using Eigen::Vector3d;

PoseError drawn(testing::Noise& noise, double mm, double rad) {
  return {mm * Vector3d(noise.normal(), noise.normal(), noise.normal()),
          rad * Vector3d(noise.normal(), noise.normal(), noise.normal())};
}

TEST(PoseError, ItsTransformIsTheProductOfEq3) {
  testing::Noise noise(3);
  for (int k = 0; k < 100; ++k) {
    const PoseError e = drawn(noise, 10, 0.5);
    EXPECT_LT((transform(e).matrix() - testing::error_transform(exact_errors(e)).matrix()).norm(), 1e-14);
  }
}

TEST(PoseError, ComesBackFromItsTransform) {
  testing::Noise noise(4);
  for (const double size : {1e-6, 1e-3, 0.3})
    for (int k = 0; k < 100; ++k) {
      const PoseError e = drawn(noise, size, size);
      EXPECT_LT((pose_error(transform(e)).vector() - e.vector()).norm(), 1e-15 + 2e-15 * size) << size;
    }
}

TEST(PoseError, DisplacesAPointAsItsTransformDoes) {
  testing::Noise noise(5);
  for (int k = 0; k < 100; ++k) {
    const PoseError e = drawn(noise, 0.02, 2e-4);
    const Vector3d p = 200 * Vector3d(noise.normal(), noise.normal(), noise.normal());
    EXPECT_LT((displacement_mm(e, p) - (transform(e) * p - p)).norm(), 1e-12);
  }
}

TEST(PoseError, KeepsTheDigitsOfTinyDisplacements) {
  const PoseError e{.rotation_rad = {0, 0, 1e-12}};
  EXPECT_NEAR(displacement_mm(e, {100, 0, 0}).y(), 1e-10, 1e-25);
}

TEST(PoseError, ItsJacobianIsTheSlopeOfTheDisplacement) {
  testing::Noise noise(6);
  constexpr double kStep = 1e-4;
  for (int k = 0; k < 20; ++k) {
    const Vector3d p = 200 * Vector3d(noise.normal(), noise.normal(), noise.normal());
    const Eigen::Matrix<double, 3, 6> jacobian = displacement_jacobian(p);
    for (Eigen::Index i = 0; i < 6; ++i) {
      const Vector3d up = displacement_mm(PoseError::from_vector(kStep * Vector6d::Unit(i)), p);
      const Vector3d down = displacement_mm(PoseError::from_vector(-kStep * Vector6d::Unit(i)), p);
      EXPECT_LT(((up - down) / (2 * kStep) - jacobian.col(i)).norm(), 1e-5) << i;  // third order: p step^2 / 6
    }
  }
}

TEST(PoseError, TheAdjointCarriesErrorsFromAFrameToR) {
  testing::Noise noise(7);
  for (int k = 0; k < 50; ++k) {
    const PoseError small = drawn(noise, 1e-6, 1e-8);
    const Eigen::Isometry3d frame = transform(drawn(noise, 80, 1));
    const Vector6d exact = pose_error(frame * transform(small) * frame.inverse(Eigen::Isometry)).vector();
    EXPECT_LT((adjoint(frame) * small.vector() - exact).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace trunnion
