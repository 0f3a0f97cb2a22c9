// Writes the calibrations of a machine that changes over a year: make_history FOLDER
//   2026-01.csv … 2026-11.csv, six calibrations by the plan of the sample, sigma 0.175 um. Between May and July the C
//   axis was moved by 6 um along X (a collision); EAA grows all the time, by 12 urad a year at A = -90.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include "support/observation_row.h"
#include "support/probing_plan.h"
#include "support/replica.h"
#include "support/virtual_machine.h"

using namespace trunnion::testing;

namespace {

constexpr int kMillimetreDecimals = 6;

VirtualMachine machine_in(int month) {
  VirtualMachine machine = replica_machine();
  const auto tilt = machine.axis('A').errors, turn = machine.axis('C').errors;
  machine.axis('A').errors = [tilt, month](const RotaryPosition& q) {
    AxisErrors e = tilt(q);
    e.rotation_rad.x() += 12e-6 * (month - 1) / 12.0 * -std::sin(q.A_rad);
    return e;
  };
  machine.axis('C').errors = [turn, month](const RotaryPosition& q) {
    AxisErrors e = turn(q);
    if (month >= 6) e.translation_mm.x() += 6e-3;
    return e;
  };
  return machine;
}

/// Five positions that a quick check takes.
bool in_check(const PlannedTouch& t) {
  return (t.A_deg == 0 && (t.C_deg == 0 || t.C_deg == 180)) ||
         (t.A_deg == -90 && (t.C_deg == 0 || t.C_deg == 120 || t.C_deg == 240));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: make_history DIR\n", stderr);
    return 2;
  }
  for (int month = 1; month <= 13; month += 2) {
    Noise noise(20260100 + static_cast<std::uint64_t>(month));
    ProbingPlan plan = replica_plan();
    plan.faces = as_built(plan.faces, noise, 20e-3, 50e-6);
    const bool check = month == 13;
    if (check) std::erase_if(plan.touches, [](const PlannedTouch& t) { return !in_check(t); });
    char name[32];
    std::snprintf(name, sizeof name, check ? "2027-01-check.csv" : "2026-%02d.csv", month);
    std::ofstream file(std::string(argv[1]) + "/" + name, std::ios::binary);
    file << csv(probe(machine_in(month), plan, {.sigma_mm = 0.175e-3}, noise), kMillimetreDecimals);
    if (!file.flush()) return 2;
  }
  return 0;
}
