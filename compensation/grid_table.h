#pragma once

#include <Eigen/Core>
#include <vector>

#include "compensation/piecewise_linear.h"

namespace trunnion {

/// How every control of this folder interpolates when it is played: linear between nodes, the end value held or the
/// table repeated.
double interpolated(const std::vector<double>& nodes, const std::vector<double>& values, Boundary boundary, double x);

/// Bilinear in two arguments, ends held: values(i, j) at (rows[i], columns[j]).
double interpolated(const std::vector<double>& rows, const std::vector<double>& columns, const Eigen::MatrixXd& values,
                    double row, double column);

}  // namespace trunnion
