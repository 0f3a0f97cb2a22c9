#include "model/effects/formula_effect.h"

#include <nlohmann/json.hpp>

#include "error.h"

namespace trunnion {
namespace {

class FormulaEffect : public Effect {
 public:
  explicit FormulaEffect(Formula formula) : formula_(std::move(formula)) {
    parameters_ = formula_.parameters;
    shape_.resize(static_cast<Eigen::Index>(formula_.shape.size()));
    for (std::size_t i = 0; i < formula_.shape.size(); ++i)
      shape_[static_cast<Eigen::Index>(i)] = formula_.shape[i].value;
  }

  std::string id() const override { return formula_.id; }
  Origin origin() const override { return formula_.origin; }
  bool moves_table() const override { return formula_.moves_table; }
  std::vector<std::string> depends_on() const override { return formula_.depends_on; }
  Matrix6Xd basis(const Situation& s) const override { return formula_.basis(s, shape_); }
  std::vector<Parameter> shape() const override { return formula_.shape; }
  std::vector<ShapeRange> shape_ranges() const override { return formula_.shape_ranges; }
  nlohmann::json to_json() const override {
    nlohmann::json json = Effect::to_json();
    for (const auto& [key, text] : formula_.keys) json[key] = text;
    return json;
  }
  void read(const nlohmann::json& json) { read_parameters(json); }

 protected:
  std::shared_ptr<Effect> clone() const override { return std::make_shared<FormulaEffect>(*this); }
  void set_shape(const Eigen::VectorXd& shape) override {
    shape_ = shape;
    for (std::size_t i = 0; i < formula_.shape.size(); ++i)
      formula_.shape[i].value = shape_[static_cast<Eigen::Index>(i)];
  }

 private:
  Formula formula_;
  Eigen::VectorXd shape_;
};

}  // namespace

EffectPtr make_effect(Formula formula) { return std::make_shared<FormulaEffect>(std::move(formula)); }

EffectPtr make_effect(Formula formula, const nlohmann::json& json) {
  auto effect = std::make_shared<FormulaEffect>(std::move(formula));
  effect->read(json);
  return effect;
}

std::string text_key(const nlohmann::json& json, const std::string& key, const std::string& effect) {
  if (!json.contains(key) || !json[key].is_string())
    throw ModelError("effect " + effect + ": " + key + " is missing, a text is wanted");
  return json[key].get<std::string>();
}

void refuse_detail(const std::string& family, const std::string& detail, const std::string& wanted) {
  throw ModelError("effect " + family + (detail.empty() ? "" : ":" + detail) + ": " + wanted +
                   " is wanted after the colon");
}

Matrix6Xd translations(double factor) {
  Matrix6Xd b = Matrix6Xd::Zero(6, 3);
  b.topRows<3>().diagonal().setConstant(factor);
  return b;
}

Matrix6Xd rotations(double factor) {
  Matrix6Xd b = Matrix6Xd::Zero(6, 3);
  b.bottomRows<3>().diagonal().setConstant(factor);
  return b;
}

}  // namespace trunnion
