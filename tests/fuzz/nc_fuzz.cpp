#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "error.h"
#include "kinematics/structure.h"
#include "postproc/program_correction.h"

// Any bytes as an NC program: no crash, no hang, an error of ours or a program; and without errors, the same bytes.

namespace {

using namespace trunnion;

class Field : public ErrorField {
 public:
  explicit Field(double scale) : scale_(scale) {}
  PoseError at(const Situation& situation) const override {
    const double a = situation.at.a.in_radians(), c = situation.at.c.in_radians();
    return scale_ * PoseError{{0.01 * std::sin(c), 0.02 * a, 0.005}, {3e-5 * a, 2e-5 * std::cos(c), 1e-5}};
  }
  Range<Angle> tilt_range() const override { return {Angle::degrees(-120), Angle::degrees(120)}; }

 private:
  double scale_;
};

std::string corrected(const std::string& program, const Field& field, bool tcp, bool keep_going, std::size_t chunk) {
  static const Machine machine = [] {
    Machine m;
    m.structure = parse_structure("w C' A' Y' b X Z t");
    m.axes = default_axes(m.structure);
    return m;
  }();
  static const KinematicChain chain(machine);
  const Corrector on(chain, field, {}), off(chain, field, {.tcp = ToolCentrePoint::off});
  ProgramCorrection how;
  how.guard = guard_of(machine);
  how.guard.most_pieces = how.guard.most_arc_pieces = 20;
  how.scan.tcp = tcp;
  how.scan.keep_going = keep_going;
  how.threads = 1;
  how.chunk_bytes = chunk;
  std::string out;
  const OpenProgram open = [&]() -> ReadBytes {
    return [&program, at = std::size_t{0}](char* buffer, std::size_t size) mutable {
      const std::size_t n = program.copy(buffer, size, at);
      at += n;
      return n;
    };
  };
  correct_program(open, [&](std::string_view text) { out += text; }, on, off, how);
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const bool tcp = (data[0] & 1) != 0, keep_going = (data[0] & 2) != 0;
  const std::string program = std::string("G0X1Y2Z3A-4C5\n") + std::string(data + 1, data + size);
  const std::size_t chunk = 16 + (data[0] >> 2);
  static const Field none(0), some(1);
  try {
    if (corrected(program, none, tcp, keep_going, chunk) != program) std::abort();
  } catch (const Error&) {
  }
  try {
    corrected(program, some, tcp, keep_going, chunk);
  } catch (const Error&) {
  }
  return 0;
}
