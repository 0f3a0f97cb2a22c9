#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace trunnion {

/// `text` with the characters that HTML keeps for itself replaced.
std::string escaped(std::string_view text);

/// `<tag attributes>content</tag>`; `content` is HTML.
std::string element(const std::string& tag, const std::string& content, const std::string& attributes = "");

/// A table of HTML cells with a caption; the first column names the row, the others stand to the right where they start
/// with a digit or a sign.
std::string html_table(const std::string& caption, const std::vector<std::string>& head,
                       const std::vector<std::vector<std::string>>& rows);

/// The text of a number with minus signs in place of hyphens, in its exponent too.
std::string with_true_minus(std::string text);

/// A value with its standard uncertainty in parallel digits, "−12.34 ± 0.21 µm"; without one to three significant
/// digits.
std::string quantity(double value, std::optional<double> std, std::string_view unit);

/// A unit as people write it: um → µm, urad → µrad.
std::string unit_symbol(std::string_view unit);

/// A probability: "<1e−16", "3.0e−08", "0.25"; HTML.
std::string probability(double p);

/// The number at a path of keys; empty where there is none.
std::optional<double> number_at(const nlohmann::json& json, const std::vector<std::string>& keys);
/// The text under a key; `otherwise` where there is none.
std::string text_at(const nlohmann::json& json, const std::string& key, const std::string& otherwise = "");

/// A list as words with commas between, escaped; "none" for an empty one.
std::string word_list(const nlohmann::json& list);

/// JSON that a script of the page reads, within the figure that it belongs to: nothing in it can end the element.
std::string script_data(const nlohmann::json& json);

}  // namespace trunnion
