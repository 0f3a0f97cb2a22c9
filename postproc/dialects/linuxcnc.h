#pragma once

#include <memory>

#include "postproc/motion.h"

namespace trunnion {

/// RS274/NGC as LinuxCNC 2.9 reads it. Corrected: G0, G1, G2 and G3 in G20/G21, G90/G91, G93/G94, work offsets G54 ...
/// G59.3, G52, G92. G53, G28, G30, a tool change and probing leave axes unknown until they are programmed again. What
/// would move the tool otherwise, or move it by numbers that are not plain, is refused.
std::unique_ptr<ProgramScanner> linuxcnc_scanner(const ScanSettings& settings);

}  // namespace trunnion
