#include "error.h"
#include "model/effects/families.h"

namespace trunnion {
namespace {

/// EXX (EYY, EZZ) growing in proportion to the coordinate: the axis goes k x too far, so that the workpiece appears
/// displaced against the tool by  d_x = -k x  (zero at R's origin), whichever side carries the axis.
class LinearScale : public Effect {
 public:
  explicit LinearScale(char axis) : axis_(axis) { parameters_ = {{std::string("E") + axis + axis, Unit::um_per_m}}; }

  std::string id() const override { return std::string("linear_scale:") + axis_; }
  Origin origin() const override { return Origin::machine; }
  std::vector<std::string> depends_on() const override {
    return {std::string(1, static_cast<char>(axis_ - 'X' + 'x')) + "_mm"};
  }
  Matrix6Xd basis(const Situation& s) const override {
    Matrix6Xd b = Matrix6Xd::Zero(6, 1);
    b(axis_ - 'X', 0) = -s.point_r_mm[axis_ - 'X'];
    return b;
  }
  void read(const nlohmann::json& json) { read_parameters(json); }

 protected:
  std::shared_ptr<Effect> clone() const override { return std::make_shared<LinearScale>(*this); }

 private:
  char axis_;
};

}  // namespace

Family linear_scale_family() {
  return {
      .name = "linear_scale",
      .what = "a linear axis measures in proportion too long or too short",
      .remedy = "a calibrated length of 150 to 300 mm along each linear axis",
      .absurd = from_unit(500, Unit::um_per_m),
      .candidates =
          [](const CandidateScope&) {
            std::vector<EffectPtr> found;
            for (const char axis : {'X', 'Y', 'Z'}) found.push_back(std::make_shared<LinearScale>(axis));
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext&) -> EffectPtr {
        if (detail != "X" && detail != "Y" && detail != "Z")
          throw ModelError("effect linear_scale:" + detail + ": an axis X, Y or Z is wanted after the colon");
        auto effect = std::make_shared<LinearScale>(detail[0]);
        effect->read(json);
        return effect;
      },
  };
}

}  // namespace trunnion
