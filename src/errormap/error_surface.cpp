#include "errormap/error_surface.h"

#include "error.h"
#include "errormap/natural_neighbour.h"
#include "errormap/tensor_surface.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

void check_stations(const std::vector<Angle>& stations, const char* axis) {
  if (stations.empty()) throw ModelError(std::string("error map: no ") + axis + " stations");
  for (std::size_t i = 1; i < stations.size(); ++i)
    if (!(stations[i - 1] < stations[i]))
      throw ModelError(std::string("error map: the ") + axis + " stations must ascend strictly");
}

void check_grid(const ErrorGrid& grid) {
  check_stations(grid.a_stations, "A");
  check_stations(grid.c_stations, "C");
  if (grid.c_stations.back() - grid.c_stations.front() >= kFullTurn)
    throw ModelError("error map: the C stations span a full turn or more; the first is not to be repeated at 360 deg");
  if (grid.tilt.size() != grid.a_stations.size() || grid.turn.size() != grid.a_stations.size() * grid.c_stations.size())
    throw ModelError("error map: the number of errors does not match the stations");
}

/// Natural neighbours for C's six; the tilting axis' six, which depend on one angle, piecewise cubic.
class NaturalSurface : public ErrorSurface {
 public:
  explicit NaturalSurface(const ErrorGrid& grid)
      : grid_(grid),
        coefficients_(grid.coefficients()),
        weights_(grid.a_stations, grid.c_stations),
        tilt_weights_(cubic_weights(grid.a_stations)) {}

  RotaryErrors at(IndexedPosition position) const override {
    const Eigen::Matrix<double, 12, 1> e = jacobian(position) * coefficients_;
    return {PoseError::from_vector(e.head<6>()), PoseError::from_vector(e.tail<6>())};
  }
  Eigen::Matrix<double, 12, Eigen::Dynamic> jacobian(IndexedPosition position) const override {
    check(position.a);
    const Eigen::VectorXd tilt = tilt_weights_(position.a.in_radians());
    const Eigen::VectorXd turn = weights_.weights(position.a, position.c);
    Eigen::Matrix<double, 12, Eigen::Dynamic> b =
        Eigen::Matrix<double, 12, Eigen::Dynamic>::Zero(12, coefficient_count());
    for (Eigen::Index i = 0; i < tilt.size(); ++i) b.block<6, 6>(0, 6 * i).diagonal().setConstant(tilt[i]);
    for (Eigen::Index k = 0; k < turn.size(); ++k)
      b.block<6, 6>(6, 6 * (tilt.size() + k)).diagonal().setConstant(turn[k]);
    return b;
  }
  Eigen::Index coefficient_count() const override { return coefficients_.size(); }
  Range<Angle> a_range() const override { return {grid_.a_stations.front(), grid_.a_stations.back()}; }

 private:
  ErrorGrid grid_;
  Eigen::VectorXd coefficients_;
  NaturalNeighbour weights_;
  StationWeights tilt_weights_;
};

}  // namespace

bool ErrorSurface::covers(Angle a) const {
  constexpr Angle kRounding = Angle::degrees(1e-9);
  const Range<Angle> range = a_range();
  return a >= range.low - kRounding && a <= range.high + kRounding;
}

void ErrorSurface::check(Angle a) const {
  const Range<Angle> range = a_range();
  if (a >= range.low - kMargin && a <= range.high + kMargin) return;
  throw RangeError(printed("tilt %.6g deg lies outside the probed range %.6g .. %.6g deg", a.in_degrees(),
                           range.low.in_degrees(), range.high.in_degrees()));
}

std::string_view interpolation_name(Interpolation method) {
  switch (method) {
    case Interpolation::trig_cubic:
      return "trig-cubic";
    case Interpolation::bilinear:
      return "bilinear";
    case Interpolation::natural_neighbour:
      return "natural-neighbour";
  }
  return {};
}

std::optional<Interpolation> interpolation_from_name(std::string_view name) {
  for (const Interpolation method :
       {Interpolation::trig_cubic, Interpolation::bilinear, Interpolation::natural_neighbour})
    if (interpolation_name(method) == name) return method;
  return std::nullopt;
}

std::unique_ptr<ErrorSurface> make_surface(Interpolation method, const ErrorGrid& grid) {
  check_grid(grid);
  switch (method) {
    case Interpolation::trig_cubic:
      return std::make_unique<TensorSurface>(grid, cubic_weights(grid.a_stations),
                                             trigonometric_weights(grid.c_stations));
    case Interpolation::bilinear:
      return std::make_unique<TensorSurface>(grid, linear_weights(grid.a_stations),
                                             periodic_linear_weights(grid.c_stations));
    case Interpolation::natural_neighbour:
      return std::make_unique<NaturalSurface>(grid);
  }
  throw ModelError("error map: an unknown interpolation");
}

}  // namespace trunnion
