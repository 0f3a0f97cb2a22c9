#include "app/map_change.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace trunnion {
namespace {

constexpr int kTilts = 9, kTurns = 24;

Model map_only(const Model& model) {
  Model map{.machine = model.machine};
  for (const EffectPtr& effect : model.effects)
    if (effect->id() == "rotary_error_map") map.effects.push_back(effect);
  return map;
}

}  // namespace

std::vector<CornerChange> change_at_corners(const Model& before, const Model& after, const WorkingVolume& volume) {
  const Model map_before = map_only(before), map_after = map_only(after);
  std::vector<CornerChange> changes;
  for (const Length z : {volume.z.low, volume.z.high})
    for (const Length y : {volume.y.low, volume.y.high})
      for (const Length x : {volume.x.low, volume.x.high}) {
        CornerChange change{.corner_mm = {x.in_millimetres(), y.in_millimetres(), z.in_millimetres()}};
        for (int i = 0; i < kTilts; ++i)
          for (int j = 0; j < kTurns; ++j) {
            Situation s;
            s.at = {volume.a.low + (i / (kTilts - 1.0)) * (volume.a.high - volume.a.low),
                    volume.c.low + (j / static_cast<double>(kTurns)) * (volume.c.high - volume.c.low)};
            s.point_r_mm = change.corner_mm;
            s.tool_length_mm = volume.tool_length.in_millimetres();
            const double map_um = 1e3 * (deviation_mm(map_after, s) - deviation_mm(map_before, s)).norm();
            const double model_um = 1e3 * (deviation_mm(after, s) - deviation_mm(before, s)).norm();
            change.map_rms += map_um * map_um / (kTilts * kTurns);
            change.model_rms += model_um * model_um / (kTilts * kTurns);
            change.map_max = std::max(change.map_max, map_um);
            if (model_um > change.model_max) change.model_max = model_um, change.worst = s.at;
          }
        change.map_rms = std::sqrt(change.map_rms), change.model_rms = std::sqrt(change.model_rms);
        changes.push_back(change);
      }
  return changes;
}

nlohmann::json map_change_json(const std::vector<CornerChange>& changes, char tilt_letter) {
  nlohmann::json corners = nlohmann::json::array();
  for (const CornerChange& c : changes)
    corners.push_back({{"x_mm", c.corner_mm.x()},
                       {"y_mm", c.corner_mm.y()},
                       {"z_mm", c.corner_mm.z()},
                       {"map_rms_um", c.map_rms},
                       {"map_max_um", c.map_max},
                       {"model_rms_um", c.model_rms},
                       {"model_max_um", c.model_max},
                       {std::string(1, tilt_letter) + "_deg", c.worst.a.in_degrees()},
                       {"C_deg", c.worst.c.in_degrees()}});
  return {{"corners", std::move(corners)}};
}

}  // namespace trunnion
