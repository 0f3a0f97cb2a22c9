#include "model/effects/location_errors.h"

#include "geometric_errors/rotary_errors.h"
#include "geometric_errors/symbol.h"
#include "model/effects/families.h"

namespace trunnion {
namespace {

class LocationErrors : public Effect {
 public:
  explicit LocationErrors(const EffectContext& context)
      : chain_(context.chain), errors_(location_errors(context.tilt_letter)) {
    for (const LocationError& error : errors_) parameters_.push_back({error.symbol, component_unit(error.component)});
    tilt_letter_ = context.tilt_letter;
  }

  std::string id() const override { return "location_errors"; }
  Origin origin() const override { return Origin::machine; }
  bool moves_table() const override { return chain_->has_rotary(Side::workpiece); }
  std::vector<std::string> depends_on() const override { return {std::string(1, tilt_letter_) + "_deg", "C_deg"}; }
  Matrix6Xd basis(const Situation& s) const override {
    const RelativeErrorJacobian j = relative_error_jacobian(*chain_, s.at, {s.point_r_mm, s.tool_length_mm});
    const Eigen::Matrix<double, 6, 12> constant = j.here + j.reference;
    Matrix6Xd b(6, 8);
    for (Eigen::Index k = 0; k < 8; ++k) {
      const LocationError& error = errors_[static_cast<std::size_t>(k)];
      b.col(k) = constant.col(static_cast<Eigen::Index>(error.component + (error.of_turning_axis ? 6 : 0)));
    }
    return b;
  }
  void read(const nlohmann::json& json) { read_parameters(json); }

 protected:
  std::shared_ptr<Effect> clone() const override { return std::make_shared<LocationErrors>(*this); }

 private:
  std::shared_ptr<const KinematicChain> chain_;
  std::array<LocationError, 8> errors_;
  char tilt_letter_;
};

}  // namespace

std::shared_ptr<const Effect> make_location_errors(const EffectContext& context) {
  return std::make_shared<LocationErrors>(context);
}

Family location_errors_family() {
  return {
      .name = "location_errors",
      .what = "the rotary axes stand elsewhere, or otherwise inclined, than the control believes",
      .remedy = "probing at a grid of A and C",
      .candidates = [](const CandidateScope&) { return std::vector<EffectPtr>(); },  // inside the rotary error map
      .read = [](const std::string&, const nlohmann::json& entry, const EffectContext& context) -> EffectPtr {
        auto effect = std::make_shared<LocationErrors>(context);
        effect->read(entry);
        return effect;
      },
  };
}

}  // namespace trunnion
