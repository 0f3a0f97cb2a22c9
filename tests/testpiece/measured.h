#pragma once

#include "support/noise.h"
#include "testpiece/independent_cut.h"
#include "testpiece/measured_piece.h"

namespace trunnion {

/// How a measuring machine reads a piece: its noise, and where the piece stood on it against where it was believed to.
struct PieceMeasurement {
  double sigma_mm = 0;
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();  ///< in W
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();  ///< about W's axes
  double grown_mm = 0;                                 ///< along the normal, everywhere: the tool's radius
};

/// A piece as a measuring machine finds it that has the given material left on its evaluated points.
inline MeasuredPiece measured(const SurfaceGrid& surface, const std::vector<double>& left_mm,
                              const PieceMeasurement& how, testing::Noise& noise) {
  MeasuredPiece found{.file = "piece.csv"};
  const std::size_t n = surface.phi_rad.size();
  for (std::size_t i = 0; i < left_mm.size(); ++i) {
    const ConePoint& on = surface.points[i];
    const double set_up = on.normal_w.dot(how.shift_mm + how.turn_rad.cross(on.point_w_mm)) + how.grown_mm;
    found.points.push_back({.line = static_cast<std::uint32_t>(i + 2),
                            .phi = Angle::radians(surface.phi_rad[i % n]),
                            .h = Length::millimetres(surface.h_mm[i / n]),
                            .deviation_mm = left_mm[i] + set_up + how.sigma_mm * noise.normal()});
  }
  return found;
}

}  // namespace trunnion
