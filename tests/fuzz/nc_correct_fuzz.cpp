#include <cmath>
#include <cstdlib>

#include "error.h"
#include "nc_input.h"
#include "postproc/playback.h"
#include "postproc/program_correction.h"

// Any bytes as an NC program of any dialect, corrected as the command does: no crash, no hang, an error of ours or a
// program; without errors of the machine, the same bytes; and what was written is played back, or said not to belong
// together.

namespace {

using namespace trunnion;

/// Smooth errors that tell their own slopes.
class Field : public ErrorField {
 public:
  explicit Field(double scale) : scale_(scale) {}
  PoseError at(const Situation& situation) const override {
    const double a = situation.at.a.in_radians(), c = situation.at.c.in_radians();
    return scale_ * PoseError{{0.01 * std::sin(c), 0.02 * a, 0.005}, {3e-5 * a, 2e-5 * std::cos(c), 1e-5}};
  }
  Slopes with_slopes(const Situation& situation) const override {
    const double c = situation.at.c.in_radians();
    return {at(situation), scale_ * PoseError{{0, 0.02, 0}, {3e-5, 0, 0}},
            scale_ * PoseError{{0.01 * std::cos(c), 0, 0}, {0, -2e-5 * std::sin(c), 0}}, true};
  }
  Range<Angle> tilt_range() const override { return {Angle::degrees(-120), Angle::degrees(120)}; }

 private:
  double scale_;
};

ProgramCorrection correction(const NcInput& in) {
  ProgramCorrection how;
  // Ways that bend are divided as always, in fewer pieces.
  how.guard.most_pieces = how.guard.most_arc_pieces = 3;
  how.dialect = in.dialect->name;
  how.keep_insertions = true;
  how.scan = nc_scan(in);
  how.threads = 1;
  how.chunk_bytes = 16;
  return how;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const NcInput in = nc_input(data, size);
  static const Field none(0), some(1);
  static const Corrector corrector[2][2] = {
      {{nc_chain(), none, {.tcp = ToolCentrePoint::off}}, {nc_chain(), none, {}}},
      {{nc_chain(), some, {.tcp = ToolCentrePoint::off}}, {nc_chain(), some, {}}},
  };
  const auto& [off, on] = corrector[in.errors ? 1 : 0];
  const ProgramCorrection how = correction(in);
  std::string out;
  try {
    const ProgramCorrectionResult result = correct_program(
        opened(in.program), [&](std::string_view text) { out += text; }, on, off, how);
    if (!in.errors && out != in.program) std::abort();
    if (result.refusals.empty()) play_back(opened(in.program), opened(out), on, how, result);
  } catch (const Error&) {
  }
  return 0;
}
