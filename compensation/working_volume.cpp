#include "compensation/working_volume.h"

#include <algorithm>
#include <cmath>

#include "error.h"
#include "model/effects/rotary_error_map.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

constexpr Length kHalfWidth = Length::millimetres(150);
constexpr Angle kAngleRounding = Angle::degrees(1e-9);

Eigen::Vector3d edges_mm(const WorkingVolume& v) {
  return {(v.x.high - v.x.low).in_millimetres(), (v.y.high - v.y.low).in_millimetres(),
          (v.z.high - v.z.low).in_millimetres()};
}

std::string degrees_text(Angle angle) { return formatted("%.6g", angle.in_degrees()); }

Range<Angle> tilt_range(const Machine& machine, const Model& model) {
  const std::string key = std::string(1, machine.tilt_letter()) + "_deg";
  std::optional<Range<Angle>> probed;
  if (const RotaryErrorMap* map = model.rotary_map()) probed = map->surface().a_range();
  if (machine.work_volume.a) {
    const Range<Angle> wanted = *machine.work_volume.a;
    if (probed && (wanted.low < probed->low - kAngleRounding || wanted.high > probed->high + kAngleRounding))
      throw RangeError("work_volume." + key + ": " + degrees_text(wanted.low) + " to " + degrees_text(wanted.high) +
                       " asked for, the model was probed from " + degrees_text(probed->low) + " to " +
                       degrees_text(probed->high));
    return wanted;
  }
  Range<Angle> range = probed.value_or(Range<Angle>{Angle::degrees(-90), Angle::degrees(90)});
  if (const auto& stroke = machine.tilt().range_angle)
    range = {std::max(range.low, stroke->low), std::min(range.high, stroke->high)};
  if (!(range.low < range.high))
    throw ModelError("work_volume." + key + ": no tilt lies both in the range of the axis and in what was probed");
  return range;
}

Range<Length> linear_range(const Machine& machine, char letter, const std::optional<Range<Length>>& wanted) {
  if (wanted) return *wanted;
  Range<Length> range{-kHalfWidth, kHalfWidth};
  if (const auto& stroke = machine.axes.at(letter).range_length)
    range = {std::max(range.low, stroke->low), std::min(range.high, stroke->high)};
  if (!(range.low < range.high))
    throw ModelError(std::string("work_volume.") + letter +
                     "_mm: the stroke does not come within 150 mm of R's origin");
  return range;
}

/// Element `index` of van der Corput's sequence in `base`, in (0, 1).
double radical_inverse(std::size_t index, std::size_t base) {
  double value = 0;
  double digit = 1.0 / static_cast<double>(base);
  for (; index > 0; index /= base, digit /= static_cast<double>(base))
    value += digit * static_cast<double>(index % base);
  return value;
}

}  // namespace

Eigen::Vector3d WorkingVolume::centre_mm() const {
  return 0.5 * Eigen::Vector3d((x.low + x.high).in_millimetres(), (y.low + y.high).in_millimetres(),
                               (z.low + z.high).in_millimetres());
}

Eigen::Vector3d WorkingVolume::variance_mm2() const { return edges_mm(*this).cwiseAbs2() / 12; }

WorkingVolume working_volume(const Machine& machine, const Model& model) {
  WorkingVolume volume;
  volume.a = tilt_range(machine, model);
  volume.c = machine.work_volume.c.value_or(Range<Angle>{Angle::degrees(0), Angle::degrees(360)});
  const auto& stroke = machine.turn().range_angle;
  if (!machine.work_volume.c && stroke && stroke->high - stroke->low < kFullTurn - kAngleRounding) volume.c = *stroke;
  volume.x = linear_range(machine, 'X', machine.work_volume.x);
  volume.y = linear_range(machine, 'Y', machine.work_volume.y);
  volume.z = linear_range(machine, 'Z', machine.work_volume.z);
  return volume;
}

std::optional<double> reference_deg(const WorkingVolume& volume) {
  if (volume.a.low > kAngleRounding || volume.a.high < -kAngleRounding) return std::nullopt;
  return 0;
}

std::vector<Situation> pose_sample(const WorkingVolume& volume, const Model& model, std::size_t count,
                                   std::size_t first) {
  const auto spread = [](auto range, double u) { return range.low + u * (range.high - range.low); };
  const bool both_tilt_senses = depends_on(model, "A_dir") || depends_on(model, "B_dir");
  const bool both_turn_senses = depends_on(model, "C_dir");
  std::vector<Situation> sample(count);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = first + k + 1;
    Situation& s = sample[k];
    s.at = {spread(volume.a, radical_inverse(i, 2)), spread(volume.c, radical_inverse(i, 3))};
    s.point_r_mm = {spread(volume.x, radical_inverse(i, 5)).in_millimetres(),
                    spread(volume.y, radical_inverse(i, 7)).in_millimetres(),
                    spread(volume.z, radical_inverse(i, 11)).in_millimetres()};
    s.tool_length_mm = volume.tool_length.in_millimetres();
    if (both_tilt_senses && radical_inverse(i, 13) < 0.5) s.tilt_sense = -1;
    if (both_turn_senses && radical_inverse(i, 17) < 0.5) s.turn_sense = -1;
  }
  return sample;
}

bool depends_on(const Model& model, const std::string& column) {
  return std::ranges::any_of(model.effects, [&](const EffectPtr& effect) {
    return effect->is_compensated() && std::ranges::count(effect->depends_on(), column) > 0;
  });
}

}  // namespace trunnion
