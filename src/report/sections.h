#pragma once

#include <string>

#include "report/evidence.h"

namespace trunnion {

/// One part of the page as HTML, and what it says in a sentence at the top. Empty where the evidence holds nothing.
struct Section {
  std::string id, title, html;
  std::string sentence = {};  ///< HTML
};

/// The machine of the results: "Middle-size trunnion, serial 0001"; empty where none says. Throws InputError where they
/// are of different machines.
std::string machine_name(const Evidence& evidence);
/// The machine, and where every number comes from: files, hashes, dates, versions, and whether they belong together.
Section provenance_section(const Evidence& evidence);
/// Each error over A and C with its band, location errors, redundancy, outliers, what no reading saw.
Section identification_section(const Evidence& evidence);
/// How well left-out angles are met.
Section interpolation_section(const Evidence& evidence);
/// Residual against every covariate before and after, each accepted effect with its evidence, what remains open.
Section closure_section(const Evidence& evidence);
/// Each controller: before, ideal, as played, and what the difference is lost to.
Section compensation_section(const Evidence& evidence);
/// Deviation along the path of each corrected program.
Section program_section(const Evidence& evidence);
/// Roundness, the unrolled flank and the part in three dimensions.
Section piece_section(const Evidence& evidence);

}  // namespace trunnion
