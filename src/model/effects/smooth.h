#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/catalogue.h"

namespace trunnion {

/// One covariate of a smooth effect. `column` is one that Situation::covariate knows, `xw_mm`, `yw_mm`, `zw_mm` (the
/// point in W), `phi_deg` (direction of the approach about Z), or `COLUMN~PERIOD`, the phase of a column in a period
/// (its own units). C_deg, phi_deg and phases are periodic, the others are held at the ends of [low, high].
struct SmoothAxis {
  std::string column;
  double low = 0;
  double high = 0;
  double length_scale = 1;  ///< in the column's units; distance over which the effect keeps its value
  friend bool operator==(const SmoothAxis&, const SmoothAxis&) = default;
};

/// How a smooth effect moves the workpiece: along an axis of R, along an axis of W as it stands, along the approach, as
/// one of the rotary joints turns, or along the approach's part along Z: what a probe does otherwise from above than
/// from the side.
enum class SmoothDirection { x, y, z, table_x, table_y, table_z, approach, about_tilt, about_turn, approach_z };
inline constexpr SmoothDirection kSmoothDirections[] = {
    SmoothDirection::x,          SmoothDirection::y,         SmoothDirection::z,        SmoothDirection::table_x,
    SmoothDirection::table_y,    SmoothDirection::table_z,   SmoothDirection::approach, SmoothDirection::about_tilt,
    SmoothDirection::about_turn, SmoothDirection::approach_z};

/// e = (f(v) - f(v0)) c, a smooth function of one or two covariates times a way to move, v0 their values at the zero of
/// every effect. f = sum_k beta_k phi_k is a Gaussian process with the squared-exponential kernel at reduced rank:
/// sine eigenfunctions of the Laplacian on a box somewhat larger than the range (Solin & Saerkkae 2020),
/// Fourier functions on a circle; products for two covariates. For a process of unit variance beta_k has
/// prior_variances()[k].
class SmoothTerm : public Effect {
 public:
  SmoothTerm(std::vector<SmoothAxis> axes, SmoothDirection direction, const EffectContext& context);

  std::string id() const override;
  /// The measurement's where it depends on the approach, the artifact, the pass or the order; else the machine's.
  Origin origin() const override;
  std::vector<std::string> depends_on() const override;
  Matrix6Xd basis(const Situation& situation) const override;
  nlohmann::json to_json() const override;

  const std::vector<SmoothAxis>& axes() const { return axes_; }
  SmoothDirection direction() const { return direction_; }
  /// phi(v) - phi(v0); zero where a covariate is not known. The basis is their product with direction_r.
  Eigen::VectorXd functions(const Situation& situation) const;
  /// c at R's origin: a unit vector (zero for the approach where nothing is touched, for its part along Z shorter), or
  /// a joint's rotation by 1 rad.
  Vector6d direction_r(const Situation& situation) const;
  /// Prior variance of each coefficient for a process of unit variance: 1 mm^2, for a rotation at a lever of 100 mm.
  const Eigen::VectorXd& prior_variances() const { return prior_variances_; }

  static std::shared_ptr<SmoothTerm> read(const std::string& detail, const nlohmann::json& json,
                                          const EffectContext& context);

 protected:
  std::shared_ptr<Effect> clone() const override { return std::make_shared<SmoothTerm>(*this); }

 private:
  Eigen::VectorXd raw_functions(const std::vector<double>& covariates) const;

  std::vector<SmoothAxis> axes_;
  SmoothDirection direction_;
  EffectContext context_;
  std::vector<std::vector<int>> terms_;  ///< per function, the number of its factor on each axis
  Eigen::VectorXd prior_variances_;
  Eigen::VectorXd at_zero_;
};

/// Throws ModelError unless there are one or two axes, each with high > low and a positive length scale (or a circle).
std::shared_ptr<const SmoothTerm> make_smooth(std::vector<SmoothAxis> axes, SmoothDirection direction,
                                              const EffectContext& context);

/// The value of a smooth axis' column in a situation; empty where it is not known.
std::optional<double> smooth_covariate(const std::string& column, const Situation& situation,
                                       const KinematicChain& chain);

}  // namespace trunnion
