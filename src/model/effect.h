#pragma once

#include <Eigen/Core>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "geometric_errors/pose_error.h"
#include "kinematics/kinematic_chain.h"
#include "model/situation.h"
#include "units/unit.h"

namespace trunnion {

/// Whose fault an effect is: the machine's, which is compensated, or the measurement's, which only cleans the fit.
enum class Origin { machine, measurement };

/// One quantity that an effect holds, in inside units (mm, rad, s, K); files show it in `unit`.
struct Parameter {
  std::string name;
  Unit unit = Unit::one;
  double value = 0;
  double absurd = 0;  ///< a magnitude beyond this (inside units) is not credible; 0: as its family says
  friend bool operator==(const Parameter&, const Parameter&) = default;
};

/// Where one number of a shape may lie, inside units; `whole` numbers can be scanned only, the others be refined.
struct ShapeRange {
  double low = 0;
  double high = 0;
  bool whole = false;
  friend bool operator==(const ShapeRange&, const ShapeRange&) = default;
};

/// One thing that can be wrong, told once for fitting, discovery, evaluation, correction, tables and prediction alike.
///
/// In a Situation it gives a PoseError, the error of the workpiece relative to the tool at R's origin: the point p of
/// the situation deviates by T(e) p - p, the workpiece is turned against the tool by e.rotation_rad. It is linear in
/// its parameters beta, e = B(situation) beta, and may hold further numbers (an order, a period, a time constant) that
/// B depends on: its shape. Effects are immutable: with_parameters and with_shape return changed copies.
class Effect {
 public:
  virtual ~Effect() = default;

  /// `family` or `family:detail` (CONTRACT).
  virtual std::string id() const = 0;
  virtual Origin origin() const = 0;
  /// Whether it moves the table as a whole, so that it counts into the table's pose error and not only at a point.
  virtual bool moves_table() const { return false; }
  /// Columns it depends on, by the names that Situation::covariate knows; rotary positions and the point included.
  virtual std::vector<std::string> depends_on() const = 0;

  /// B(situation), 6 x parameters().size(): mm and rad per inside unit of each parameter.
  virtual Matrix6Xd basis(const Situation& situation) const = 0;
  /// B beta; an effect may do better than first order.
  virtual PoseError at(const Situation& situation) const;
  /// Covariance of at(situation), 6 x 6 (mm, rad); zero where none is known.
  virtual Matrix6d covariance_at(const Situation& situation) const;

  /// The fitted parameters beta.
  const std::vector<Parameter>& parameters() const { return parameters_; }
  Eigen::VectorXd values() const;
  /// Covariance of values(), inside units; empty if not known.
  const Eigen::MatrixXd& covariance() const { return covariance_; }
  /// A copy with other values; `covariance` may be empty.
  std::shared_ptr<const Effect> with_parameters(const Eigen::VectorXd& values, const Eigen::MatrixXd& covariance) const;

  /// Whether it is corrected, tabulated and predicted: one of the machine that is not suspended.
  bool is_compensated() const { return origin() == Origin::machine && !suspended_; }
  /// Set aside: an effect of the machine that the data cannot tell from one of the measurement. It cleans the fit and
  /// is shown, but never compensated.
  bool is_suspended() const { return suspended_; }
  std::shared_ptr<const Effect> suspended() const;

  /// The numbers of the shape, empty for most effects.
  virtual std::vector<Parameter> shape() const { return {}; }
  /// One range for each of them.
  virtual std::vector<ShapeRange> shape_ranges() const { return {}; }
  /// A copy with another shape, parameters kept. Throws ModelError for an effect without one, or outside its ranges.
  std::shared_ptr<const Effect> with_shape(const Eigen::VectorXd& shape) const;

  /// `{"id", "origin", "parameters": {NAME: {"value", "std", "unit"}}}`, with "shape", "covariance" and "suspended"
  /// where there are any. The map writes itself otherwise.
  virtual nlohmann::json to_json() const;

 protected:
  virtual std::shared_ptr<Effect> clone() const = 0;
  virtual void set_shape(const Eigen::VectorXd&) {}
  /// Called after with_parameters: for an effect that keeps more than parameters_ and covariance_.
  virtual void parameters_changed() {}
  /// Restores shape, parameters and covariance from what to_json wrote. Throws ModelError naming the key.
  void read_parameters(const nlohmann::json& json);

 private:
  void refuse_outside_ranges(const Eigen::VectorXd& shape) const;
  void read_shape(const nlohmann::json& json);

  bool suspended_ = false;

 protected:
  std::vector<Parameter> parameters_;
  Eigen::MatrixXd covariance_;
};

/// Effects are immutable, so models share them.
using EffectPtr = std::shared_ptr<const Effect>;

}  // namespace trunnion
