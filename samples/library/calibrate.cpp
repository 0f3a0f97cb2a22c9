// calibrate MACHINE.toml OBSERVATIONS.csv MODEL.json: error maps from readings, and the deviation at one position.
#include <cstdio>

#include "error.h"
#include "identification/identify.h"
#include "io/machine_file.h"
#include "io/model_file.h"
#include "io/observation_file.h"
#include "io/output_file.h"

int main(int count, char** words) try {
  if (count != 4) throw trunnion::UsageError("calibrate MACHINE.toml OBSERVATIONS.csv MODEL.json");
  const trunnion::Machine machine = trunnion::read_machine(words[1]);
  const trunnion::ObservationSet observations = trunnion::read_observations(words[2], machine);
  const trunnion::IdentificationResult found = trunnion::identify(observations, machine);
  for (const trunnion::ErrorFinding& error : found.errors)
    std::printf("%s %7.3f +- %.3f %s\n", error.symbol.c_str(), trunnion::to_unit(error.largest, error.unit),
                trunnion::to_unit(error.largest_std, error.unit), trunnion::unit_text(error.unit).text.data());

  trunnion::Situation there;
  there.at = {trunnion::Angle::degrees(-75), trunnion::Angle::degrees(270)};
  there.point_r_mm = {80, -40, 100};
  const Eigen::Vector3d d_um = 1e3 * trunnion::deviation_mm(found.model, there);
  std::printf("deviation at A -75 C 270: %.3f %.3f %.3f um\n", d_um.x(), d_um.y(), d_um.z());
  trunnion::write_whole(words[3], trunnion::model_text(found.model), {words[1], words[2]});
  return 0;
} catch (const trunnion::Error& error) {
  std::fprintf(stderr, "calibrate: %s\n", error.what());
  return 2;
}
