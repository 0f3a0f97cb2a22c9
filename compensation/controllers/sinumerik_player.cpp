#include <cmath>
#include <map>
#include <optional>

#include "compensation/controllers/sinumerik_assignments.h"
#include "compensation/controllers/sinumerik_tables.h"
#include "compensation/controllers/sinumerik_trafo5.h"
#include "compensation/grid_table.h"
#include "compensation/number_text.h"
#include "error.h"
#include "units/angle.h"

// What a SINUMERIK does with the files that it was given: written from its manuals, not from the emitter.

namespace trunnion::sinumerik {
namespace {

/// One table as the control holds it.
struct HeldTable {
  std::string output;
  Curve curve;
  int direction = 0;
  std::size_t multiply_by = 0;
  bool on = true;
};

class Reader : public SinumerikAssignments {
 public:
  using SinumerikAssignments::SinumerikAssignments;

  /// The nodes MIN + N STEP and their values, `node_index` giving the index text of node N.
  template <class NodeIndex>
  Curve curve(const std::string& name, const std::string& index, NodeIndex node_index) const {
    const double step = number(name + "_STEP", index), from = number(name + "_MIN", index),
                 to = number(name + "_MAX", index);
    const double cells = (to - from) / step;
    if (!(step > 0) || !(cells >= 1) || !(cells < 1e5) || std::abs(cells - std::round(cells)) > 1e-6)
      throw InputError(file_name(), name + "[" + index + "]: (MAX - MIN) / STEP is " + shortest_text(cells) +
                                        ", a whole number is wanted");
    Curve c;
    c.boundary = number(name + "_IS_MODULO", index) == 1 ? Boundary::repeat : Boundary::hold;
    const auto last = static_cast<std::size_t>(std::round(cells));
    for (std::size_t n = 0; n <= last; ++n) {
      c.nodes.push_back(n == last ? to : from + static_cast<double>(n) * step);
      c.values.push_back(number(name, node_index(n)));
    }
    if (c.boundary == Boundary::repeat && c.values.front() != c.values.back())
      throw InputError(file_name(), name + "[" + index + "]: a modulo table jumps where it closes: " +
                                        shortest_text(c.values.front()) + " and " + shortest_text(c.values.back()));
    return c;
  }
};

class Sinumerik : public PlayedCompensation {
 public:
  explicit Sinumerik(const CompensationTask& task) : tilt_(task.machine.tilt_letter()) {
    for (const auto& [axis, number] : axis_numbers(task)) letters_[axis_name(task, axis)] = axis;
    sign_ = task.profile.answer("cec_sign") == "subtract" ? -1 : 1;
    replaces_ = task.profile.answer("cec_product") == "instead of the table's own value";
    needs_on_ = task.profile.answer("cec_factor") == "must be switched on";
  }

  void load_transformation(const TableFile& file, const CompensationTask& task) {
    nominal_ = task.chain;
    believed_ = read_trafo5(file, task);
  }

  void load_encoder(const TableFile& file) {
    const Reader reader(file);
    for (const auto& [index, value] : reader.all("$AA_ENC_COMP_STEP")) {
      const std::string axis = index.substr(index.find(',') + 1);
      Curve c =
          reader.curve("$AA_ENC_COMP", index, [&](std::size_t n) { return "0," + std::to_string(n) + "," + axis; });
      c.input = letter(file, axis);
      encoder_.push_back(std::move(c));
    }
  }

  void load_sag(const TableFile& file) {
    const Reader reader(file);
    for (const auto& [index, value] : reader.all("$AN_CEC_STEP")) {
      const auto t = integer_from(index);
      if (!t || *t < 0 || *t > 9999)
        throw InputError(file.name, "$AN_CEC_STEP[" + index + "]: a table index is wanted");
      HeldTable table;
      table.curve = reader.curve("$AN_CEC", index,
                                 [&, &index = index](std::size_t n) { return index + "," + std::to_string(n); });
      table.curve.input = letter(file, reader.text("$AN_CEC_INPUT_AXIS", index));
      table.output = std::string(1, letter(file, reader.text("$AN_CEC_OUTPUT_AXIS", index)));
      table.direction = static_cast<int>(reader.number("$AN_CEC_DIRECTION", index));
      const double factor = reader.number("$AN_CEC_MULT_BY_TABLE", index);
      if (!(factor >= 0 && factor <= 9999))
        throw InputError(file.name, "$AN_CEC_MULT_BY_TABLE[" + index + "]: a table number is wanted");
      table.multiply_by = static_cast<std::size_t>(factor);
      table.on = reader.number("$SN_CEC_TABLE_ENABLE", index) == 1;
      sag_[static_cast<std::size_t>(*t)] = std::move(table);
    }
    for (const auto& [t, table] : sag_)
      if (table.multiply_by != 0 && !sag_.contains(table.multiply_by - 1))
        throw InputError(file.name, "$AN_CEC_MULT_BY_TABLE[" + std::to_string(t) + "]: there is no table number " +
                                        std::to_string(table.multiply_by));
  }

  AxisCorrection at(const Situation& s) const override {
    const std::map<char, double> position = {{'X', s.point_r_mm.x()},
                                             {'Y', s.point_r_mm.y()},
                                             {'Z', s.point_r_mm.z() + s.tool_length_mm},
                                             {tilt_, s.at.a.in_degrees()},
                                             {'C', s.at.c.in_degrees()}};
    std::map<char, double> moved;
    const auto value = [&](const Curve& c) {
      return interpolated(c.nodes, c.values, c.boundary, position.at(c.input));
    };
    // The actual value is raised by the table, so the axis ends up that much lower.
    for (const Curve& c : encoder_) moved[c.input] -= value(c);
    for (const auto& [t, table] : sag_) {
      const int sense = table.curve.input == 'C' ? s.turn_sense : table.curve.input == tilt_ ? s.tilt_sense : 0;
      if (!table.on || (table.direction != 0 && table.direction != sense)) continue;
      const double plain = value(table.curve);
      double sum = plain;
      if (table.multiply_by != 0) {
        const HeldTable& factor = sag_.at(table.multiply_by - 1);
        const double product = needs_on_ && !factor.on ? 0 : plain * value(factor.curve);
        sum = replaces_ ? product : plain + product;
      }
      moved[table.output[0]] += sign_ * sum;
    }
    const auto of = [&](char axis) { return moved.contains(axis) ? moved.at(axis) : 0.0; };
    Eigen::Vector3d linear(of('X'), of('Y'), of('Z'));
    // The transformation goes where it believes the point of the workpiece to be.
    if (believed_)
      linear += believed_->r_from_w(s.at) * (nominal_->r_from_w(s.at).inverse() * s.point_r_mm) - s.point_r_mm;
    return {linear, of(tilt_) * kDegree_rad, of('C') * kDegree_rad};
  }

 private:
  char letter(const TableFile& file, const std::string& axis) const {
    const auto found = letters_.find(axis);
    if (found == letters_.end()) throw InputError(file.name, "axis " + axis + ": not an axis of this machine");
    return found->second;
  }

  char tilt_;
  double sign_;
  bool replaces_, needs_on_;
  std::map<std::string, char> letters_;
  std::vector<Curve> encoder_;
  std::map<std::size_t, HeldTable> sag_;
  std::optional<KinematicChain> nominal_, believed_;
};

}  // namespace

std::unique_ptr<PlayedCompensation> play(const std::vector<TableFile>& files, const CompensationTask& task) {
  auto control = std::make_unique<Sinumerik>(task);
  bool any = false;
  for (const TableFile& file : files) {
    if (file.name.ends_with("_EEC.INI")) control->load_encoder(file), any = true;
    if (file.name == kCecFile) control->load_sag(file), any = true;
    if (file.name == kTrafo5File) control->load_transformation(file, task);
  }
  if (!any) throw InputError(kCecFile, "missing, and there is no *_EEC.INI");
  return control;
}

}  // namespace trunnion::sinumerik
