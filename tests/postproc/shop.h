#pragma once

#include <algorithm>
#include <cstring>
#include <string>

#include "error.h"
#include "judged_machine.h"
#include "nc_player.h"
#include "postproc/program_correction.h"

namespace trunnion {

/// A machine, errors times `scale`, and a way to correct text on it.
struct Shop {
  explicit Shop(const std::string& structure = "w C' A' Y' b X Z t", double scale = 1)
      : both(judged(structure)), field(both, scale), chain(both.machine) {
    how.guard = guard_of(both.machine);
    how.scan.letters[kTilt] = both.machine.tilt_letter();
    how.name = "part.ngc";
    how.header = "model 1a2b, machine Trunnion, serial 7";
  }

  std::string correct(std::string_view program) {
    CorrectionSettings off = settings;
    off.tcp = ToolCentrePoint::off;
    const Corrector with_tcp(chain, field, settings), without_tcp(chain, field, off);
    std::string out;
    const OpenProgram open = [&]() -> ReadBytes {
      return [program, at = std::size_t{0}](char* buffer, std::size_t size) mutable {
        const std::size_t n = std::min(size, program.size() - at);
        std::memcpy(buffer, program.data() + at, n);
        at += n;
        return n;
      };
    };
    result = correct_program(
        open, [&](std::string_view text) { out += text; }, with_tcp, without_tcp, how);
    return out;
  }

  /// The message of the refusal, or what was written.
  std::string refusal(std::string_view program) {
    try {
      return correct(program);
    } catch (const Error& error) {
      return error.what();
    }
  }

  Miss missed(const testing::PlayedMove& wanted, const testing::PlayedMove& sent) const {
    const auto place = [](const testing::PlayedMove& move) {
      return Commanded{{move.at[0], move.at[1], move.at[2]}, {Angle::degrees(move.at[3]), Angle::degrees(move.at[4])}};
    };
    CorrectionSettings as = settings;
    as.tcp = how.scan.tcp ? ToolCentrePoint::on : ToolCentrePoint::off;
    return miss(both, place(wanted), place(sent), as);
  }

  Judged both;
  TrueField field;
  KinematicChain chain;
  CorrectionSettings settings;
  ProgramCorrection how;
  ProgramCorrectionResult result;
};

}  // namespace trunnion
