#pragma once

#include <map>
#include <string>
#include <vector>

namespace trunnion {

/// The numbers of a CSV file by column, row by row; NaN where a field is no number.
using NumberTable = std::map<std::string, std::vector<double>>;

/// One result of a command, and the files beside it that belong to it.
struct EvidenceFile {
  std::string path;  ///< as it is to be called on the page
  std::string text;  ///< JSON: model, closure, verification of tables, correction or prediction
  std::map<std::string, NumberTable> tables;    ///< residuals.csv, flank.csv, by name
  std::map<std::string, std::string> pictures;  ///< roundness_h10.svg …, by name
};

/// Which kind of result a JSON text is, by what it says of itself; none as well where it is no JSON.
enum class EvidenceKind { none, model, closure, tables, correction, prediction };
EvidenceKind evidence_kind(const std::string& text);

/// The page: one HTML file without outside references, a section for each kind of result that is there. Throws
/// InputError naming the file for a result of another machine than the first's.
std::string evidence_page(const std::vector<EvidenceFile>& files);

}  // namespace trunnion
