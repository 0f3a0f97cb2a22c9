#pragma once

#include <map>
#include <string>

#include "compensation/controller.h"

namespace trunnion {

/// What an initialisation file of a SINUMERIK assigns: `$VARIABLE[index]=value`, comments behind `;`, M17 at the end.
class SinumerikAssignments {
 public:
  /// Throws InputError with the line for what is no assignment, and where the end is missing.
  explicit SinumerikAssignments(const TableFile& file);

  /// Throws InputError where `name[index]` is not assigned, or is no number.
  const std::string& text(const std::string& name, const std::string& index) const;
  double number(const std::string& name, const std::string& index) const;
  /// Index to value; empty for a variable that does not occur.
  const std::map<std::string, std::string>& all(const std::string& name) const;
  const std::string& file_name() const { return file_name_; }

 private:
  std::string file_name_;
  std::map<std::string, std::map<std::string, std::string>> values_;
  std::map<std::string, std::size_t> lines_;  ///< of "variable[index]"
};

}  // namespace trunnion
