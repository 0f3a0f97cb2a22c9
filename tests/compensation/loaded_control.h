#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "compensation/controller.h"
#include "model/model.h"
#include "sample_models.h"
#include "units/angle.h"

namespace trunnion::compensation_test {

/// A control with files of ours in it.
class Loaded {
 public:
  explicit Loaded(const std::string& controller, std::map<std::string, ProfileValue> profile = {},
                  const std::string& structure = "w C' A' Y' b X Z t")
      : controller_(controller_named(controller)), machine_(trunnion_machine(controller)) {
    machine_.structure = parse_structure(structure);
    machine_.profile = std::move(profile);
  }

  void load(const std::vector<TableFile>& files) {
    task_ = std::make_unique<CompensationTask>(machine_, nothing_, TableOptions{}, controller_.questions);
    played_ = controller_.play(files, *task_);
  }

  AxisCorrection at(double a_deg, double c_deg, const Eigen::Vector3d& point_mm = {0, 0, 0}, int tilt_sense = 1,
                    int turn_sense = 1) const {
    Situation s;
    s.at = {Angle::degrees(a_deg), Angle::degrees(c_deg)};
    s.point_r_mm = point_mm;
    s.tilt_sense = tilt_sense;
    s.turn_sense = turn_sense;
    return played_->at(s);
  }
  double tilt_deg(double a_deg, int sense = 1) const { return at(a_deg, 0, {0, 0, 0}, sense).tilt_rad / kDegree_rad; }
  double turn_deg(double c_deg, int sense = 1) const {
    return at(0, c_deg, {0, 0, 0}, 1, sense).turn_rad / kDegree_rad;
  }

 private:
  const Controller& controller_;
  Machine machine_;
  Model nothing_;
  std::unique_ptr<CompensationTask> task_;
  std::unique_ptr<PlayedCompensation> played_;
};

}  // namespace trunnion::compensation_test
