#pragma once

#include "model/catalogue.h"

namespace trunnion {

/// The eight location errors of a tilting rotary table as one effect, relative to the reference pose:
///   Delta = u + Ad(A) v - Ad(A) Ad(C) (u + v)   with the constants u of the tilting axis and v of C in their joints'
///   frames.
std::shared_ptr<const Effect> make_location_errors(const EffectContext& context);

}  // namespace trunnion
