// Writes instruments.csv, what four instruments say of the machine of the sample calibration: make_instruments FOLDER
//   R-test: three balls, three displacements each, at 24 positions; ball-bar: one ball on the table, the bar radial to
//   C; encoders of both axes, C's at A = 0 and A's at C = 0; an autocollimator about Z at C = 0.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <string>

#include "support/observation_row.h"
#include "support/probing_plan.h"
#include "support/replica.h"
#include "support/virtual_machine.h"

using namespace trunnion::testing;
using Eigen::Vector3d;

namespace {

constexpr double kDisplacement_mm = 0.3e-3;  // of an R-test or a ball-bar, 1 sigma
constexpr double kRotation_rad = 1e-6;       // of an encoder or an autocollimator
constexpr int kDecimals = 6;

ObservationRow told(ObservationRow row, const char* instrument, double sigma_um) {
  row.artifact = instrument;
  row.sigma_um = sigma_um;
  return row;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: make_instruments DIR\n", stderr);
    return 2;
  }
  const VirtualMachine machine = replica_machine();
  Noise noise(20261126);
  std::vector<ObservationRow> rows;
  double time_s = 0;
  const auto at = [&](double A_deg, double C_deg) {
    time_s += 10;
    return PlannedTouch{.A_deg = A_deg, .C_deg = C_deg, .time_s = time_s};
  };
  int ball = 0;
  for (const Vector3d& place : {Vector3d(80, 0, 60), Vector3d(-40, 70, 60), Vector3d(-30, -60, 140)}) {
    const std::string name = "ball " + std::to_string(++ball);
    const Vector3d off(noise.uniform(-0.01, 0.01), noise.uniform(-0.01, 0.01), noise.uniform(-0.01, 0.01));
    for (const double A_deg : {0., -30., -60., -90.})
      for (const double C_deg : {0., 60., 120., 180., 240., 300.}) {
        const PlannedTouch where = at(A_deg, C_deg);
        for (int k = 0; k < 3; ++k)
          rows.push_back(told(
              displacement_row(machine, where, name, place, off, Vector3d::Unit(k), kDisplacement_mm * noise.normal()),
              "R-test", 1e3 * kDisplacement_mm));
      }
  }
  const Vector3d bar_ball(0, 100, 50), bar_off(0.004, -0.007, 0.002);
  for (const double A_deg : {0., -30., -60., -90.})
    for (const double C_deg : {0., 60., 120., 180., 240., 300.}) {
      const PlannedTouch where = at(A_deg, C_deg);
      const double c = C_deg * std::numbers::pi / 180, a = A_deg * std::numbers::pi / 180;
      const Vector3d radial(-std::sin(c), std::cos(c) * std::cos(a), std::cos(c) * std::sin(a));
      rows.push_back(
          told(displacement_row(machine, where, "bar", bar_ball, bar_off, radial, kDisplacement_mm * noise.normal()),
               "ball-bar", 1e3 * kDisplacement_mm));
    }
  const auto rotation = [&](double A_deg, double C_deg, const char* instrument, const Vector3d& axis, double zero) {
    rows.push_back(rotation_row(machine, at(A_deg, C_deg), instrument, axis, zero, kRotation_rad * noise.normal()));
    rows.back().sigma_um.reset();
  };
  for (const double C_deg : {0., 60., 120., 180., 240., 300.})
    rotation(0, C_deg, "encoder of C", Vector3d::UnitZ(), 3e-6);
  for (const double A_deg : {0., -30., -60., -90.}) {
    rotation(A_deg, 0, "encoder of A", Vector3d::UnitX(), -5e-6);
    rotation(A_deg, 0, "autocollimator", Vector3d::UnitZ(), 40e-6);
  }
  std::ofstream file(std::string(argv[1]) + "/instruments.csv", std::ios::binary);
  file << csv(rows, kDecimals);
  return file.flush() ? 0 : 2;
}
