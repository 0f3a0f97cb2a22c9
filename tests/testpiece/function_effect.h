#pragma once

#include <functional>

#include "model/effect.h"

namespace trunnion {

/// Any error of the machine, as a function: for tests.
class FunctionEffect : public Effect {
 public:
  explicit FunctionEffect(std::function<PoseError(const Situation&)> error) : error_(std::move(error)) {}
  std::string id() const override { return "function"; }
  Origin origin() const override { return Origin::machine; }
  std::vector<std::string> depends_on() const override { return {}; }
  Matrix6Xd basis(const Situation&) const override { return Matrix6Xd(6, 0); }
  PoseError at(const Situation& situation) const override { return error_(situation); }

 protected:
  std::shared_ptr<Effect> clone() const override { return std::make_shared<FunctionEffect>(*this); }

 private:
  std::function<PoseError(const Situation&)> error_;
};

}  // namespace trunnion
