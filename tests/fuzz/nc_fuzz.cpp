#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "error.h"
#include "kinematics/structure.h"
#include "postproc/playback.h"
#include "postproc/program_correction.h"

// Any bytes as an NC program of any dialect: no crash, no hang, an error of ours or a program; without errors, the same
// bytes; and what was written is played back, or said not to belong together.

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

struct Beginning {
  const char* name;
  const char* head;  // all axes known
};
const Beginning kDialects[] = {
    {"linuxcnc", "G0X1Y2Z3A-4C5\n"},
    {"fanuc", "G21G90\nG0A-4.C5.\nG43.4H1X1.Y2.Z3.\n"},
    {"sinumerik", "TRAORI\nG0 X1 Y2 Z3 A=-4 C=5\n"},
    {"heidenhain", "L A-4 C+5 FMAX\nM128\nL X+1 Y+2 Z+3 FMAX\n"},
};

std::string corrected(const std::string& program, const Field& field, const std::string& dialect, bool tcp,
                      bool keep_going, std::size_t chunk) {
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
  how.dialect = dialect;
  how.keep_insertions = true;
  how.scan.tcp = tcp;
  how.scan.chain = &chain;
  how.scan.tilt_stroke_deg = {-120, 30};
  how.scan.control.whole_numbers = tcp ? "units" : "increments";
  how.scan.control.tcp_frame = keep_going ? "start" : tcp ? "zero" : "fixed";
  how.scan.keep_going = keep_going;
  how.threads = 1;
  how.chunk_bytes = chunk;
  std::string out;
  const ProgramCorrectionResult result = correct_program(
      opened(program), [&](std::string_view text) { out += text; }, on, off, how);
  if (result.refusals.empty()) play_back(opened(program), opened(out), on, how, result);
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const bool tcp = (data[0] & 1) != 0, keep_going = (data[0] & 2) != 0;
  const Beginning& dialect = kDialects[(data[0] >> 2) & 3];
  const std::string program = dialect.head + std::string(data + 1, data + size);
  const std::size_t chunk = 16 + (data[0] >> 4);
  static const Field none(0), some(1);
  try {
    if (corrected(program, none, dialect.name, tcp, keep_going, chunk) != program) std::abort();
  } catch (const Error&) {
  }
  try {
    corrected(program, some, dialect.name, tcp, keep_going, chunk);
  } catch (const Error&) {
  }
  return 0;
}
