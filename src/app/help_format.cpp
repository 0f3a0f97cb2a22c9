#include "app/help_format.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <set>
#include <string>

namespace trunnion {
namespace {

/// "FLOAT:FLOAT in [0.01 - 1000]", which is how CLI11 tells a type and its check, taken apart.
struct Wanted {
  std::string type;    ///< "NUMBER"
  std::string bounds;  ///< "0.01 to 1000"; empty: none
};

Wanted wanted(const std::string& type_name) {
  Wanted w{.type = type_name.substr(0, type_name.find(':')), .bounds = {}};
  if (const std::size_t from = type_name.find(" in ["); from != std::string::npos) {
    w.bounds = type_name.substr(from + 5, type_name.find(']', from) - from - 5);
    w.bounds.replace(w.bounds.find(" - "), 3, " to ");
  }
  if (w.type == "TEXT")
    if (const std::size_t choice = type_name.find('{'); choice != std::string::npos) w.type = type_name.substr(choice);
  if (w.type == "FLOAT") w.type = "NUMBER";
  if (w.type == "INT" || w.type == "UINT") w.type = "COUNT";
  return w;
}

std::string names(const std::set<CLI::Option*>& options) {
  std::string text;
  for (const CLI::Option* option : options) text += (text.empty() ? "" : ", ") + option->get_name();
  return text;
}

class HelpFormat : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
};

std::string HelpFormat::make_option_opts(const CLI::Option* option) const {
  if (option->get_type_size() == 0) return "";
  std::string text = " " + wanted(option->get_type_name()).type;
  if (option->get_expected_max() == CLI::detail::expected_max_vector_size && !text.ends_with("...")) text += " ...";
  return text + (option->get_required() ? " REQUIRED" : "");
}

std::string HelpFormat::make_option_desc(const CLI::Option* option) const {
  std::string more;
  const auto add = [&](const std::string& text) { more += (more.empty() ? "" : "; ") + text; };
  if (option->get_type_size() != 0) {
    if (const std::string bounds = wanted(option->get_type_name()).bounds; !bounds.empty()) add(bounds);
    if (!option->get_default_str().empty()) add("default " + option->get_default_str());
  }
  if (!option->get_needs().empty()) add("only with " + names(option->get_needs()));
  if (!option->get_excludes().empty()) add("not with " + names(option->get_excludes()));
  return option->get_description() + (more.empty() ? "" : " (" + more + ")");
}

}  // namespace

void set_help_format(CLI::App& program) { program.formatter(std::make_shared<HelpFormat>()); }

}  // namespace trunnion
