#include "python/active.h"

#include "app/active_compensation.h"

namespace trunnion::python {

std::shared_ptr<const ObservationSet> without(const Active& active, const ObservationSet& set, const Machine& machine) {
  if (!active) return std::make_shared<const ObservationSet>(set);
  std::vector<std::string> inputs;
  if (const Model* model = std::get_if<Model>(&*active))
    return std::make_shared<const ObservationSet>(without_active(set, *model, machine));
  if (const auto* tables = std::get_if<const Tables*>(&*active))
    return std::make_shared<const ObservationSet>(without_active(set, (*tables)->set.files, machine));
  return std::make_shared<const ObservationSet>(
      without_active(set, std::get<std::filesystem::path>(*active).string(), machine, inputs));
}

}  // namespace trunnion::python
