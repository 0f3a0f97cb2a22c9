#include "model/effect.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "error.h"
#include "model/json_value.h"

namespace trunnion {

using nlohmann::json;

PoseError Effect::at(const Situation& situation) const { return PoseError::from_vector(basis(situation) * values()); }

Matrix6d Effect::covariance_at(const Situation& situation) const {
  if (covariance_.size() == 0) return Matrix6d::Zero();
  const Matrix6Xd b = basis(situation);
  return b * covariance_ * b.transpose();
}

Eigen::VectorXd Effect::values() const {
  Eigen::VectorXd v(static_cast<Eigen::Index>(parameters_.size()));
  for (std::size_t i = 0; i < parameters_.size(); ++i) v[static_cast<Eigen::Index>(i)] = parameters_[i].value;
  return v;
}

std::shared_ptr<const Effect> Effect::with_parameters(const Eigen::VectorXd& values,
                                                      const Eigen::MatrixXd& covariance) const {
  const auto n = static_cast<Eigen::Index>(parameters_.size());
  if (values.size() != n || (covariance.size() != 0 && (covariance.rows() != n || covariance.cols() != n)))
    throw ModelError("effect " + id() + ": " + std::to_string(n) +
                     " parameters, and a covariance of them or none, are wanted");
  std::shared_ptr<Effect> copy = clone();
  for (std::size_t i = 0; i < parameters_.size(); ++i)
    copy->parameters_[i].value = values[static_cast<Eigen::Index>(i)];
  copy->covariance_ = covariance;
  copy->parameters_changed();
  return copy;
}

std::shared_ptr<const Effect> Effect::suspended() const {
  std::shared_ptr<Effect> copy = clone();
  copy->suspended_ = true;
  return copy;
}

std::shared_ptr<const Effect> Effect::with_shape(const Eigen::VectorXd& shape) const {
  if (this->shape().empty()) throw ModelError("effect " + id() + " has no shape to set");
  refuse_outside_ranges(shape);
  std::shared_ptr<Effect> copy = clone();
  copy->set_shape(shape);
  return copy;
}

void Effect::refuse_outside_ranges(const Eigen::VectorXd& numbers) const {
  const std::vector<Parameter> names = shape();
  const std::vector<ShapeRange> ranges = shape_ranges();
  if (static_cast<std::size_t>(numbers.size()) != names.size())
    throw ModelError("effect " + id() + ": a shape of " + std::to_string(names.size()) + " numbers is wanted");
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const double value = numbers[static_cast<Eigen::Index>(i)];
    const auto shown = [&](double inside) { return json(to_unit(inside, names[i].unit)).dump(); };
    if (!(value >= ranges[i].low && value <= ranges[i].high) || (ranges[i].whole && value != std::floor(value)))
      throw ModelError("effect " + id() + ": shape." + names[i].name + ": " + shown(value) + " found, " +
                       (ranges[i].whole ? "a whole number of " : "a number of ") + shown(ranges[i].low) + " to " +
                       shown(ranges[i].high) + " " + std::string(unit_text(names[i].unit).text) + " is wanted");
  }
}

json Effect::to_json() const {
  json j;
  j["id"] = id();
  j["origin"] = origin() == Origin::machine ? "machine" : "measurement";
  if (suspended_) j["suspended"] = true;
  json parameters = json::object();
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    const Parameter& p = parameters_[i];
    const auto k = static_cast<Eigen::Index>(i);
    json entry = {{"value", to_unit(p.value, p.unit)}, {"unit", unit_text(p.unit).text}};
    if (covariance_.size() != 0) entry["std"] = to_unit(std::sqrt(covariance_(k, k)), p.unit);
    parameters[p.name] = std::move(entry);
  }
  j["parameters"] = std::move(parameters);
  if (const std::vector<Parameter> numbers = shape(); !numbers.empty()) {
    json entry = json::object();
    for (const Parameter& p : numbers)
      entry[p.name] = {{"value", to_unit(p.value, p.unit)}, {"unit", unit_text(p.unit).text}};
    j["shape"] = std::move(entry);
  }
  if (covariance_.rows() > 1) {  // lower triangle, in the units of the parameters
    json rows = json::array();
    for (Eigen::Index r = 0; r < covariance_.rows(); ++r) {
      json row = json::array();
      for (Eigen::Index c = 0; c <= r; ++c)
        row.push_back(to_unit(to_unit(covariance_(r, c), parameters_[static_cast<std::size_t>(r)].unit),
                              parameters_[static_cast<std::size_t>(c)].unit));
      rows.push_back(std::move(row));
    }
    j["covariance"] = std::move(rows);
  }
  return j;
}

void Effect::read_shape(const json& j) {
  const std::vector<Parameter> names = shape();
  if (names.empty()) return;
  const std::string where = "effect " + id();
  if (!j.contains("shape") || !j["shape"].is_object()) throw ModelError(where + ": \"shape\" is missing");
  Eigen::VectorXd numbers(static_cast<Eigen::Index>(names.size()));
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string key = where + ": shape." + names[i].name;
    if (!j["shape"].contains(names[i].name)) throw ModelError(key + " is missing");
    const json& entry = j["shape"][names[i].name];
    if (!entry.is_object() || !entry.contains("value") || !entry.contains("unit"))
      throw ModelError(key + ": {\"value\", \"unit\"} is wanted");
    if (entry["unit"] != unit_text(names[i].unit).text)
      throw ModelError(key + ".unit: " + entry["unit"].dump() + " found, \"" +
                       std::string(unit_text(names[i].unit).text) + "\" is wanted");
    numbers[static_cast<Eigen::Index>(i)] = from_unit(number(entry["value"], key + ".value"), names[i].unit);
  }
  refuse_outside_ranges(numbers);
  set_shape(numbers);
}

void Effect::read_parameters(const json& j) {
  read_shape(j);
  const std::string where = "effect " + id();
  if (!j.contains("parameters") || !j["parameters"].is_object())
    throw ModelError(where + ": \"parameters\" is missing");
  const json& given = j["parameters"];
  for (const auto& [name, entry] : given.items()) {
    bool known = false;
    for (const Parameter& p : parameters_) known = known || p.name == name;
    if (!known) throw ModelError(where + ": parameter \"" + name + "\" is not known");
  }
  const auto n = static_cast<Eigen::Index>(parameters_.size());
  Eigen::VectorXd std = Eigen::VectorXd::Constant(n, -1);
  for (Eigen::Index i = 0; i < n; ++i) {
    Parameter& p = parameters_[static_cast<std::size_t>(i)];
    const std::string key = where + ": parameters." + p.name;
    if (!given.contains(p.name)) throw ModelError(key + " is missing");
    const json& entry = given[p.name];
    if (!entry.is_object() || !entry.contains("value") || !entry.contains("unit"))
      throw ModelError(key + ": {\"value\", \"unit\"} is wanted");
    if (entry["unit"] != unit_text(p.unit).text)
      throw ModelError(key + ".unit: " + entry["unit"].dump() + " found, \"" + std::string(unit_text(p.unit).text) +
                       "\" is wanted");
    p.value = from_unit(number(entry["value"], key + ".value"), p.unit);
    if (entry.contains("std") && !entry["std"].is_null())
      std[i] = from_unit(number(entry["std"], key + ".std"), p.unit);
  }
  if (j.contains("covariance")) {
    const json& rows = j["covariance"];
    if (!rows.is_array() || static_cast<Eigen::Index>(rows.size()) != n)
      throw ModelError(where + ": covariance: a lower triangle of " + std::to_string(n) + " rows is wanted");
    covariance_.resize(n, n);
    for (Eigen::Index r = 0; r < n; ++r) {
      const json& row = rows[static_cast<std::size_t>(r)];
      if (!row.is_array() || static_cast<Eigen::Index>(row.size()) != r + 1)
        throw ModelError(where + ": covariance row " + std::to_string(r) + ": " + std::to_string(r + 1) +
                         " numbers are wanted");
      for (Eigen::Index c = 0; c <= r; ++c)
        covariance_(r, c) = covariance_(c, r) =
            from_unit(from_unit(number(row[static_cast<std::size_t>(c)], where + ": covariance"),
                                parameters_[static_cast<std::size_t>(r)].unit),
                      parameters_[static_cast<std::size_t>(c)].unit);
    }
  } else if (n > 0 && std.minCoeff() >= 0) {
    covariance_ = std.cwiseAbs2().asDiagonal();
  }
}

}  // namespace trunnion
