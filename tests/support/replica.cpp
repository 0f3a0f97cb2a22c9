#include "support/replica.h"

#include <cmath>
#include <cstdint>

#include "support/noise.h"
#include "support/probing_plan.h"

namespace trunnion::testing {
namespace {

constexpr std::uint64_t kSeed = 20100521;
constexpr double kSigma_mm = 0.175e-3;
constexpr double kEAA_urad = 34.906585;  // 2e-3 deg

/// Location errors EY0A EZ0A EB0A EC0A and error motions of A.
AxisErrors errors_of_A(const RotaryPosition& q) {
  const double s = std::sin(q.A_rad), c = std::cos(q.A_rad), s2 = std::sin(2 * q.A_rad);
  return um_urad(1.8 * s + 0.6 * s2,                     //
                 3.0 - 2.4 * (1 - c) + 0.9 * s2,         //
                 -2.2 + 1.7 * s,                         //
                 kEAA_urad * (0.7 * (1 - c) - 0.3 * s),  //
                 2.0 + 4.5 * s - 1.5 * s2,               //
                 -4.0 - 3.0 * (1 - c) + 2.0 * s);
}

/// Location errors EX0C EY0C EB0C and error motions of C, two harmonics that vary with A.
AxisErrors errors_of_C(const RotaryPosition& q) {
  const double s = std::sin(q.A_rad);
  const double c1 = std::cos(q.C_rad), s1 = std::sin(q.C_rad), c2 = std::cos(2 * q.C_rad), s2 = std::sin(2 * q.C_rad);
  return um_urad(2.5 + 1.2 * c1 - 0.8 * s1 + (0.9 + 0.4 * s) * c2,   //
                 -1.7 + 0.9 * c1 + (1.1 - 0.5 * s) * s1 - 0.6 * s2,  //
                 0.7 * c1 - 0.5 * s1 + 0.4 * c2,                     //
                 1.9 * c1 + (1.4 + 0.8 * s) * s2,                    //
                 1.2 - 1.3 * s1 + (1.6 - 0.7 * s) * c2,              //
                 5.0 * s1 + (2.5 + 1.5 * s) * c2 - 3.0 * c1);
}

}  // namespace

VirtualMachine replica_machine() {
  VirtualMachine machine = perfect_machine("w C' A' Y' b X Z t");
  machine.axis('A').errors = errors_of_A;
  machine.axis('C').errors = errors_of_C;
  return machine;
}

std::vector<ObservationRow> replica_observations() {
  Noise noise(kSeed);
  ProbingPlan plan = replica_plan();
  plan.faces = as_built(plan.faces, noise, 0.020, 50e-6);
  return probe(replica_machine(), plan, {.sigma_mm = kSigma_mm}, noise);
}

GaugedMaps replica_truth() { return gauged_maps(replica_machine(), {0, -30, -60, -90}, {0, 60, 120, 180, 240, 300}); }

std::string truth_csv(const GaugedMaps& maps, int decimals) {
  std::string text =
      "A_deg,C_deg,EXA_um,EYA_um,EZA_um,EAA_urad,EBA_urad,ECA_urad,EXC_um,EYC_um,EZC_um,EAC_urad,EBC_urad,ECC_urad,"
      "Dx_um,Dy_um,Dz_um,Da_urad,Db_urad,Dc_urad\n";
  for (std::size_t i = 0; i < maps.tilt_deg.size(); ++i)
    for (std::size_t j = 0; j < maps.C_deg.size(); ++j) {
      const std::size_t cell = i * maps.C_deg.size() + j;
      text.append(csv_number(maps.tilt_deg[i])).append(",").append(csv_number(maps.C_deg[j]));
      for (const AxisErrors* errors : {&maps.tilt[i], &maps.C[cell], &maps.pose[cell]}) {
        for (double mm : errors->translation_mm) text.append(",").append(csv_number(mm * 1e3, decimals));
        for (double rad : errors->rotation_rad) text.append(",").append(csv_number(rad * 1e6, decimals));
      }
      text += "\n";
    }
  return text;
}

}  // namespace trunnion::testing
