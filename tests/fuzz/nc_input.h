#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "kinematics/structure.h"
#include "postproc/dialect.h"

namespace trunnion {

/// What the bytes of an input say: the first chooses dialect and settings, the others are the program.
struct NcInput {
  const Dialect* dialect = nullptr;
  std::string program;
  bool tcp = false;         ///< bit 0
  bool keep_going = false;  ///< bit 1; dialect: bits 2 and 3
  bool errors = false;      ///< bit 4: the machine has some
  bool in_chunks = false;   ///< bit 6: so long a comment stands before the program that it is read in many pieces
};

/// The bench, whose axes all stand at known places when the program begins.
inline const KinematicChain& nc_chain() {
  static const Machine machine = [] {
    Machine m;
    m.structure = parse_structure("w C' A' Y' b X Z t");
    m.axes = default_axes(m.structure);
    return m;
  }();
  static const KinematicChain chain(machine);
  return chain;
}

inline NcInput nc_input(const std::uint8_t* data, std::size_t size) {
  struct Beginning {
    const char* name;
    const char* head;  // all axes known
  };
  static constexpr Beginning kBeginnings[] = {
      {"linuxcnc", "G0X1Y2Z3A-4C5\n"},
      {"fanuc", "G21G90\nG0A-4.C5.\nG43.4H1X1.Y2.Z3.\n"},
      {"sinumerik", "TRAORI\nG0 X1 Y2 Z3 A=-4 C=5\n"},
      {"heidenhain", "L A-4 C+5 FMAX\nM128\nL X+1 Y+2 Z+3 FMAX\n"},
  };
  const std::uint8_t first = data[0];
  const Beginning& beginning = kBeginnings[(first >> 2) & 3];
  NcInput in{.dialect = &dialect(beginning.name),
             .tcp = (first & 1) != 0,
             .keep_going = (first & 2) != 0,
             .errors = (first & 16) != 0,
             .in_chunks = (first & 64) != 0};
  if (in.in_chunks)
    in.program.append(in.dialect->text.comment_open)
        .append(std::string(480, '-'))
        .append(in.dialect->text.comment_close)
        .append("\n");
  in.program.append(beginning.head).append(data + 1, data + size);
  return in;
}

/// What the scan is told of program and machine.
inline ScanSettings nc_scan(const NcInput& in) {
  ScanSettings scan;
  scan.tcp = in.tcp;
  scan.chain = &nc_chain();
  scan.tilt_stroke_deg = {-120, 30};
  scan.control.whole_numbers = in.tcp ? "units" : "increments";
  scan.control.tcp_frame = in.keep_going ? "start" : in.tcp ? "zero" : "fixed";
  scan.keep_going = in.keep_going;
  return scan;
}

}  // namespace trunnion
