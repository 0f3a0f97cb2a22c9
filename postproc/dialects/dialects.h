#pragma once

#include <memory>

#include "postproc/motion.h"

// One file a dialect: which words and codes there are, what they do to the state of the program, and what is refused.

namespace trunnion {

/// RS274/NGC as LinuxCNC 2.9 reads it. Corrected: G0, G1, G2 and G3 in G20/G21, G90/G91, G93/G94, work offsets G54 ...
/// G59.3, G52, G92. G53, G28, G30 and a tool change leave axes unknown until they are programmed again. What would move
/// the tool otherwise, or move it by numbers that are not plain, is refused; so it is in every dialect.
std::unique_ptr<ProgramScanner> linuxcnc_scanner(const ScanSettings& settings);

/// FANUC series 30i: G43.4 and G43.5 (tool-centre-point control, by angles and by vectors), G68.2 with G53.1 (tilted
/// working plane), G54.1 P, G52, G92; ; ends a block, O names the program.
std::unique_ptr<ProgramScanner> fanuc_scanner(const ScanSettings& settings);

/// SINUMERIK 840D sl and ONE: TRAORI and TRAFOOF, A3= B3= C3=, X=AC() and IC(), CR=, CIP, CT, G54 ... G57, G505 ...
/// G599, TRANS and ATRANS, CYCLE800 axis by axis.
std::unique_ptr<ProgramScanner> sinumerik_scanner(const ScanSettings& settings);

/// HEIDENHAIN Klartext: L, C, CR, CT, LN, CC; M128, FUNCTION TCPM, cycle 7, PLANE SPATIAL.
std::unique_ptr<ProgramScanner> heidenhain_scanner(const ScanSettings& settings);

}  // namespace trunnion
