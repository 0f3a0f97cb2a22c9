// Writes calibration.csv and later.csv, a machine with an effect that nobody declared: make_close FOLDER
//   The machine of the sample calibration, whose C stands 14 urad short of its command when it was last turned
//   backwards. Two passes of the sample's plan, the second backwards; a verification at other angles an hour later.
#include <cstdio>
#include <fstream>
#include <string>

#include "support/probing_plan.h"
#include "support/replica.h"
#include "support/undeclared_effects.h"

using namespace trunnion::testing;

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: make_close DIR\n", stderr);
    return 2;
  }
  constexpr double kBacklash_rad = 14e-6, kSigma_mm = 0.175e-3;
  constexpr int kDecimals = 6;
  VirtualMachine machine = replica_machine();
  add_rotary_backlash(machine, 'C', kBacklash_rad);
  Noise noise(20261127);
  ProbingPlan plan = two_top_plan();
  plan.faces = as_built(plan.faces, noise, 20e-3, 50e-6);
  plan = three_passes(plan);
  std::erase_if(plan.touches, [](const PlannedTouch& t) { return t.repeat > 1; });
  const ProbingPlan later =
      verification_plan(plan.faces, {.seed = 7, .poses = 16}, {.start_s = plan.touches.back().time_s + 3600});
  for (const auto& [name, touches] : {std::pair("calibration.csv", plan), std::pair("later.csv", later)}) {
    std::ofstream file(std::string(argv[1]) + "/" + name, std::ios::binary);
    file << csv(probe(machine, touches, {.sigma_mm = kSigma_mm}, noise), kDecimals);
    if (!file.flush()) return 2;
  }
  return 0;
}
