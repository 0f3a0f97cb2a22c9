#pragma once

#include <memory>
#include <optional>

#include "errormap/error_grid.h"
#include "errormap/harmonic_surface.h"
#include "model/catalogue.h"

namespace trunnion {

/// What a rotary error map is made of. The grid is what was found at the indexed positions; the surface says what holds
/// between them.
struct RotaryMapContent {
  ErrorGrid grid;
  std::vector<bool> unseen;         ///< one per grid coefficient that no measurement determines; empty: all are seen
  Eigen::MatrixXd grid_covariance;  ///< of grid.coefficients(), mm and rad; empty if not known
  bool full_covariance = false;     ///< whether grid_covariance is more than the squares of standard uncertainties

  Interpolation interpolation = Interpolation::trig_cubic;  ///< between the nodes, where there is no smooth surface
  std::optional<HarmonicBasis> smooth_basis;                ///< a smooth surface fitted to all readings, if set
  std::string smooth_method;                                ///< "structured" or "gaussian-process"
  bool filled = false;  ///< whether the smooth surface may stand in where a freedom was not seen
  Eigen::VectorXd smooth_coefficients;
  Eigen::MatrixXd smooth_covariance;  ///< empty if not known
  /// What the interpolation itself may be wrong by between the nodes: standard deviations of D (mm) and theta (rad).
  double interpolation_sigma_mm = 0;
  double interpolation_sigma_rad = 0;
};

/// The twelve rotary error functions EXA … ECC on (A, C), as one effect: the table's error relative to the reference
/// pose,
///   T(Delta) = T(A,C) T(0,0)^-1 T~(A,C)^-1   (CONTRACT; Ibaraki, Iritani & Matsushita 2010, Eq. 3, 6, 10),
/// exact, whatever map it came from. Its parameters are the coefficients of the surface in use.
class RotaryErrorMap : public Effect {
 public:
  /// Throws ModelError for a contradictory grid, or one whose tilt range does not reach the reference pose A = 0.
  RotaryErrorMap(RotaryMapContent content, const EffectContext& context);

  std::string id() const override { return "rotary_error_map"; }
  Origin origin() const override { return Origin::machine; }
  bool moves_table() const override;
  std::vector<std::string> depends_on() const override;
  /// Throws RangeError outside the probed tilt, or where a freedom that nothing determined would be needed: with a
  /// smooth surface, nearer to such a pose than to any other node; between nodes alone, anywhere.
  Matrix6Xd basis(const Situation& situation) const override;
  PoseError at(const Situation& situation) const override;
  Matrix6d covariance_at(const Situation& situation) const override;
  nlohmann::json to_json() const override;

  const RotaryMapContent& content() const { return content_; }
  const ErrorSurface& surface() const { return *surface_; }
  bool has_uncertainty() const;
  /// "EXC at A -30 C 60" … for what no measurement determines.
  std::vector<std::string> unseen_freedoms() const;

  static std::shared_ptr<RotaryErrorMap> read(const nlohmann::json& json, const EffectContext& context);

 protected:
  std::shared_ptr<Effect> clone() const override { return std::make_shared<RotaryErrorMap>(*this); }
  /// Takes the surface's new coefficients into the content; beside a smooth surface, the values at the nodes move as
  /// the surface does and have its uncertainty.
  void parameters_changed() override;

 private:
  void use(std::shared_ptr<const ErrorSurface> surface);
  void refuse_unseen(IndexedPosition position) const;
  bool touches_unseen(IndexedPosition position) const;

  RotaryMapContent content_;
  EffectContext context_;
  std::shared_ptr<const ErrorSurface> surface_;
  RotaryErrors reference_;
  Eigen::Matrix<double, 12, Eigen::Dynamic> reference_jacobian_;
};

}  // namespace trunnion
