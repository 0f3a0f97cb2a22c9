#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "model/model.h"

namespace trunnion {

/// A calibration's model and when it was taken.
struct DatedModel {
  double years = 0;  ///< on any clock common to all
  Model model;
};

/// The same values of one error in one calibration after another.
struct ErrorSeries {
  /// The values in one calibration, at the places of the series.
  struct Point {
    std::size_t calibration = 0;  ///< index into the models
    Eigen::VectorXd values;       ///< inside units
    Eigen::MatrixXd covariance;
  };
  std::string name;                     ///< EX0C, EXA, "linear_scale:X scale"
  Unit unit = Unit::um;                 ///< in files
  std::vector<IndexedPosition> places;  ///< of the values; empty for a single number that holds everywhere
  std::vector<Point> points;            ///< in the order of the models
};

/// A way in which the compared values may change, as a linear combination of columns.
struct ChangeMode {
  std::string name;
  Unit unit = Unit::um;
  std::vector<IndexedPosition> places;  ///< of what is shown; empty for a single number
  Eigen::MatrixXd design;               ///< the change of the values per unit of each coefficient, inside units
  Eigen::MatrixXd shown;  ///< rows that make what people are told of a change of the values; empty: the coefficient
};

/// Values that all calibrations have, and what may change in them.
struct ChangeProblem {
  std::vector<ErrorSeries::Point> points;
  std::vector<ChangeMode> modes;
};

/// What can be followed over the calibrations of one machine.
struct SeriesSet {
  std::vector<ErrorSeries> locations;   ///< the eight location errors
  std::vector<ErrorSeries> functions;   ///< EXA … ECC at common positions, location errors included
  std::vector<ErrorSeries> parameters;  ///< of the machine's other effects, where two or more calibrations have them
  ChangeProblem poses;                  ///< all pose errors, as changes of location errors and functions
  std::vector<std::size_t> left_out;    ///< models without a map or without its standard uncertainties
};

/// Takes models of `machine` apart into comparable series.
///
/// Compared are the table's pose errors Delta (relative to A = C = 0) at positions that all maps cover: stations of the
/// last one, at most 5 tilts by 8 turns of them, evenly thinned. A map that was determined at those positions gives
/// what was found there, unsmoothed; another gives its surface. Location errors are estimated from all of Delta by the
/// same generalised least squares in every calibration (weights of the mean covariance), so that a shape which location
/// errors do not explain cannot look like a change of them. Functions are told apart by Eq. (1) over the common
/// positions; on a machine where that is not possible (a rotary axis in the head) they are the components Dx … Dc of
/// Delta at R's origin.
SeriesSet error_series(std::span<const DatedModel> models, const Machine& machine);

}  // namespace trunnion
