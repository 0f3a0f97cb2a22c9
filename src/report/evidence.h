#pragma once

#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace trunnion {

/// What a command writes that the page can show.
enum class ResultKind { model, closure, tables, correction, prediction };

/// The columns of a CSV file by name, all of one length; NaN where a field is no number.
using NumberColumns = std::map<std::string, std::vector<double>>;

using TextColumns = std::map<std::string, std::vector<std::string>>;

/// A result as it stands in a folder.
struct ResultFile {
  ResultKind kind = ResultKind::model;
  std::string path;     ///< as the user called it
  std::string sha256;   ///< of its bytes
  std::string changed;  ///< the day it was last changed, "2026-03-01"
  std::shared_ptr<const nlohmann::json> content;
  NumberColumns columns;  ///< beside a closure its residuals, beside a prediction the deviations at its heights
  TextColumns labels;     ///< beside a closure: the columns of its residuals that hold other words than numbers
  NumberColumns flank;    ///< beside a prediction the whole flank
};

/// What a page is made from, in the order in which it was given.
struct Evidence {
  std::vector<ResultFile> results;
  std::string program;  ///< that makes the page, with its version
  std::string date;     ///< of the page
};

}  // namespace trunnion
