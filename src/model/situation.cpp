#include "model/situation.h"

namespace trunnion {

std::optional<double> Situation::covariate(std::string_view name) const {
  if (name == "time_s") return time_s;
  if (name == "temperature_C") return temperature_C;
  if (name == "A_dir" || name == "B_dir") return tilt_sense;
  if (name == "C_dir") return turn_sense;
  if (name == "A_deg" || name == "B_deg") return at.a.in_degrees();
  if (name == "C_deg") return at.c.in_degrees();
  if (name == "x_mm") return point_r_mm.x();
  if (name == "y_mm") return point_r_mm.y();
  if (name == "z_mm") return point_r_mm.z();
  if (name == "nx") return approach_r.x();
  if (name == "ny") return approach_r.y();
  if (name == "nz") return approach_r.z();
  if (name == "repeat") return repeat;
  if (name == "order") return order;
  if (name == "order_in_pose") return order_in_pose;
  if (extra.names != nullptr)
    for (std::size_t i = 0; i < extra.names->size(); ++i)
      if ((*extra.names)[i] == name) return extra.values[i];
  return std::nullopt;
}

}  // namespace trunnion
