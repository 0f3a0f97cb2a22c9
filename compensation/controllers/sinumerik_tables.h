#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compensation/controller.h"
#include "compensation/piecewise_linear.h"

// The files of a SINUMERIK: encoder error compensation (EEC), where an axis corrects itself, and sag compensation
// (CEC), functions of one axis that act on another and products of two of them.

namespace trunnion::sinumerik {

constexpr const char* kCecFile = "CEC.INI";

/// The control's name of a machine axis by the profile, e.g. AX4.
std::string axis_name(const CompensationTask& task, char axis);
/// The first lines of a file called `name` on the control.
std::string header(const CompensationTask& task, const std::string& name);

/// A function of one axis at even nodes.
struct Curve {
  char input = 'A';
  std::vector<double> nodes, values;
  Boundary boundary = Boundary::hold;
};

/// A contribution to one output axis, in mm or degrees: a curve, or the product of two.
struct Term {
  char output = 'X';
  Curve curve;
  std::optional<Curve> factor;
  int direction = 0;
  double gain = 0;    ///< mean square of the deviation that it takes away, mm^2
  bool ramp = false;  ///< `factor` is a coordinate itself, which terms share
};

/// The encoder compensation of `curve.input`, degrees to be added to the command.
TableFile eec_file(const CompensationTask& task, const Curve& curve, Emission emission);

/// All tables of CEC.INI: numbers run as tables are added.
class CecFile {
 public:
  CecFile(const CompensationTask& task, Emission emission);

  /// How many tables `term` takes on top of what is there.
  std::size_t cost(const Term& term) const;
  void add(const Term& term);

  std::size_t tables() const { return count_; }
  TableFile file() const;

 private:
  /// Writes one table and returns its number (its index plus one).
  std::size_t write(char output, const Curve& curve, std::size_t multiply_by, int direction, int decimals,
                    bool switched_on);

  const CompensationTask& task_;
  Emission emission_;
  double sign_;
  bool adds_plain_, factor_alone_;
  std::size_t count_ = 0;
  std::map<char, std::size_t> ramps_;
  std::string text_;
};

/// The control with these files in it, drafts included. Throws InputError for what it would not take.
std::unique_ptr<PlayedCompensation> play(const std::vector<TableFile>& files, const CompensationTask& task);

}  // namespace trunnion::sinumerik
