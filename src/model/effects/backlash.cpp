#include "error.h"
#include "model/effects/families.h"
#include "model/joint_motion.h"

namespace trunnion {
namespace {

/// Lost motion of a rotary axis: having last turned in the negative sense, it stands `b` further along its axis'
/// right-handed sense than having come from the other side. Zero for the positive sense (CONTRACT: zero of every
/// effect). With the joint's nominal frame (Q, t) at the position:  e = Ad(Q, t) (0; direction b).
class Backlash : public Effect {
 public:
  Backlash(char axis, const EffectContext& context) : axis_(axis), chain_(context.chain) {
    index_ = axis == 'C' ? chain_->turn_index() : chain_->tilt_index();
    parameters_ = {{"reversal", Unit::urad}};
  }

  std::string id() const override { return std::string("backlash:") + axis_; }
  Origin origin() const override { return Origin::machine; }
  bool moves_table() const override { return chain_->rotary_joints()[index_].side == Side::workpiece; }
  std::vector<std::string> depends_on() const override { return {std::string(1, axis_) + "_dir"}; }
  Matrix6Xd basis(const Situation& s) const override {
    Matrix6Xd b = Matrix6Xd::Zero(6, 1);
    const int sense = axis_ == 'C' ? s.turn_sense : s.tilt_sense;
    if (sense >= 0) return b;
    b = joint_rotation(*chain_, index_, s);
    return b;
  }
  void read(const nlohmann::json& json) { read_parameters(json); }

 protected:
  std::shared_ptr<Effect> clone() const override { return std::make_shared<Backlash>(*this); }

 private:
  char axis_;
  std::shared_ptr<const KinematicChain> chain_;
  std::size_t index_;
};

}  // namespace

Family backlash_family() {
  return {
      .name = "backlash",
      .what = "a rotary axis stops elsewhere when it comes from the other side",
      .remedy = "some poses approached from the other side of each rotary axis, with A_dir and C_dir recorded",
      .absurd = from_unit(500, Unit::urad),
      .candidates =
          [](const CandidateScope& scope) {
            std::vector<EffectPtr> found;
            for (const char axis : {scope.context.tilt_letter, 'C'})
              found.push_back(std::make_shared<Backlash>(axis, scope.context));
            return found;
          },
      .read = [](const std::string& detail, const nlohmann::json& json, const EffectContext& context) -> EffectPtr {
        if (detail.size() != 1 || (detail[0] != 'C' && detail[0] != context.tilt_letter))
          throw ModelError("effect backlash:" + detail + ": a rotary axis of the machine is wanted after the colon");
        auto effect = std::make_shared<Backlash>(detail[0], context);
        effect->read(json);
        return effect;
      },
  };
}

}  // namespace trunnion
