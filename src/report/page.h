#pragma once

#include <string>
#include <vector>

#include "report/chart.h"

namespace trunnion {

/// The page of evidence while it is written: sections of text, tables and charts, in one file that needs no other.
class Page {
 public:
  explicit Page(std::string title) : title_(std::move(title)) {}

  void section(const std::string& id, const std::string& heading, const std::string& lead);
  void heading(const std::string& text);
  void paragraph(const std::string& text, const std::string& css_class = "");
  /// The first row is the header; a first column of words, numbers to the right.
  void table(const std::vector<std::vector<std::string>>& rows, const std::string& caption);
  void charts(const std::vector<Chart>& charts);
  /// An SVG that is whole in itself.
  void picture(const std::string& svg, const std::string& caption);
  /// A place where the script shows the part in three dimensions: `part` as the script wants it (JSON), `still` without
  /// it.
  void part(const std::string& part, const std::string& still);

  std::string html() const;

 private:
  std::string title_, body_, contents_;
  std::vector<std::string> charts_, parts_;  ///< JSON
  bool open_ = false;
};

}  // namespace trunnion
