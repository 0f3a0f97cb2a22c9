#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "report/html.h"
#include "report/sections.h"
#include "testpiece/colour_scale.h"
#include "testpiece/cone_evaluation.h"
#include "testpiece/plots.h"
#include "units/number_text.h"

namespace trunnion {
namespace {

using nlohmann::json;

constexpr const char* kCuts[] = {"uncompensated", "tables", "corrected", "ideal", "measured"};
constexpr std::size_t kMapTurns = 90, kMapHeights = 11;  ///< of the still map
constexpr int kPalette = 129;

/// A grid of heights by phi, and how the piece was cut there.
struct Flank {
  std::vector<double> heights_mm;
  std::size_t turns = 0;
  std::vector<std::pair<std::string, std::vector<double>>> cuts_um;
};

/// `deviation_um` is that of the cut which the prediction was asked for and which has no column of its own.
std::optional<Flank> flank_of(const NumberColumns& columns, const json& prediction) {
  const auto h = columns.find("h_mm"), phi = columns.find("phi_deg");
  if (h == columns.end() || phi == columns.end() || h->second.empty()) return std::nullopt;
  Flank flank;
  for (std::size_t i = 0; i < h->second.size(); ++i)
    if (i == 0 || h->second[i] != h->second[i - 1]) flank.heights_mm.push_back(h->second[i]);
  flank.turns = h->second.size() / flank.heights_mm.size();
  if (flank.turns < 3 || flank.turns * flank.heights_mm.size() != h->second.size()) return std::nullopt;
  for (const char* cut : kCuts)
    if (const auto own = columns.find(std::string(cut) + "_um"); own != columns.end())
      flank.cuts_um.emplace_back(cut, own->second);
    else if (const auto asked = columns.find("deviation_um");
             asked != columns.end() && cut != std::string("measured") && prediction.contains(cut))
      flank.cuts_um.emplace_back(cut, asked->second);
  return flank.cuts_um.empty() ? std::nullopt : std::optional(flank);
}

/// The unrolled flank of one cut, coarse enough for a page.
std::string still_map(const Flank& flank, const std::string& cut, const std::vector<double>& values_um, double end_um) {
  const std::size_t every_turn = std::max<std::size_t>(1, flank.turns / kMapTurns);
  const std::size_t every_height = std::max<std::size_t>(1, (flank.heights_mm.size() - 1) / (kMapHeights - 1));
  std::vector<double> heights, deviation_mm;
  std::size_t turns = 0;
  for (std::size_t j = 0; j < flank.heights_mm.size(); j += every_height) {
    heights.push_back(flank.heights_mm[j]);
    turns = 0;
    for (std::size_t k = 0; k + every_turn <= flank.turns; k += every_turn, ++turns)
      deviation_mm.push_back(1e-3 * values_um[j * flank.turns + k]);
  }
  return unrolled_map_svg("Deviation of the flank, " + cut, turns, heights, deviation_mm, end_um);
}

std::string polar_plots(const NumberColumns& columns, const json& prediction) {
  const auto flank = flank_of(columns, prediction);
  if (!flank) return "";
  const Angle half_angle = Angle::degrees(number_at(prediction, {"piece", "half_angle_deg"}).value_or(0));
  const double base_radius_mm = number_at(prediction, {"piece", "base_diameter_mm"}).value_or(0) / 2;
  const EvaluationOptions evaluation{.filter_upr = number_at(prediction, {"filter_upr"})};
  if (!(base_radius_mm > 0)) return "";  // roundness is told about a circle
  std::string figures;
  for (std::size_t j = 0; j < flank->heights_mm.size(); ++j) {
    std::vector<PolarCurve> curves;
    for (const auto& [cut, values_um] : flank->cuts_um) {
      ConeTrace trace{.h_mm = flank->heights_mm[j],
                      .nominal_radius_mm = base_radius_mm - flank->heights_mm[j] * std::tan(half_angle.in_radians())};
      for (std::size_t k = 0; k < flank->turns; ++k) {
        trace.phi_rad.push_back(2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(flank->turns));
        trace.normal_mm.push_back(1e-3 * values_um[j * flank->turns + k]);
      }
      curves.push_back({cut, radial_trace(trace, half_angle, evaluation)});
    }
    const std::string h = quantity(flank->heights_mm[j], std::nullopt, "mm");
    figures += element("figure",
                       polar_plot_svg("Roundness at h = " + h, curves) + element("figcaption", "Roundness at h = " + h),
                       "class=\"picture\"");
  }
  return element("h3", "Roundness") + element("div", figures, "class=\"charts\"");
}

std::string colour_text(Colour colour) {
  return "rgb(" + std::to_string(colour[0]) + "," + std::to_string(colour[1]) + "," + std::to_string(colour[2]) + ")";
}

/// The part for the page's script, which draws it; its still maps stand in without.
std::string part_view(const Flank& flank, const json& prediction, std::size_t number) {
  double largest = 0;
  json cuts = json::object();
  for (const auto& [cut, values_um] : flank.cuts_um) {
    json values = json::array();
    for (const double v : values_um) {
      largest = std::max(largest, std::abs(v));
      values.push_back(std::isfinite(v) ? std::round(1e3 * v) / 1e3 : 0.0);
    }
    cuts[cut] = std::move(values);
  }
  json palette = json::array();
  std::string stops;
  for (int k = 0; k < kPalette; ++k) {
    const Colour colour = deviation_colour(2.0 * k / (kPalette - 1) - 1);
    palette.push_back({colour[0], colour[1], colour[2]});
    stops += (stops.empty() ? "" : ",") + colour_text(colour);
  }
  const double end_um = round_scale(largest);
  const json data = {{"piece", prediction["piece"]}, {"heights_mm", flank.heights_mm},
                     {"turns", flank.turns},         {"cuts", std::move(cuts)},
                     {"scale_um", end_um},           {"palette", std::move(palette)}};
  std::string options, stills;
  for (const auto& [cut, values_um] : flank.cuts_um) {
    options += element("option", escaped(cut), "value=\"" + escaped(cut) + "\"");
    stills += element(
        "figure", still_map(flank, cut, values_um, end_um) + element("figcaption", "Unrolled flank, " + escaped(cut)),
        "class=\"picture\"");
  }
  const std::string n = std::to_string(number), scale = quantity(end_um, std::nullopt, "um");
  const auto choice = [&](const std::string& side) {
    return "<label>" + side + " <select class=\"" + side + "\">" + options + "</select></label>\n";
  };
  std::string controls =
      choice("left") + choice("right") + "<label for=\"magnify" + n + "\">magnification <input id=\"magnify" + n +
      "\" type=\"range\" min=\"0\" max=\"100\" value=\"50\"> <output for=\"magnify" + n + "\"></output></label>\n";
  std::string view = element("div", controls, "class=\"controls\"") + "<div class=\"stage\"></div>\n" +
                     element("p",
                             "−" + scale + " <span class=\"bar\" style=\"background:linear-gradient(90deg," + stops +
                                 ")\"></span> +" + scale + " (blue: material missing, red: material left)",
                             "class=\"scale\"") +
                     element("p", "Turn with the mouse or the arrow keys; + and − zoom.", "class=\"note\"") +
                     element("p", "", "class=\"reading\" role=\"status\"");
  return element("h3", "The part, coloured by its deviation") +
         element("figure",
                 element("figcaption", "The part before and after, side by side") +
                     element("div", view, "class=\"live\" hidden") + script_data(data),
                 "class=\"part\"") +
         element("h3", "The flank unrolled") + element("div", stills, "class=\"charts wide\"");
}

/// The 95 % interval of a quantity that cannot be negative: its draws lie above zero, beside the value itself.
std::string interval(const json& j, const std::string& key) {
  if (!j.contains(key + "_95") || j[key + "_95"].size() != 2) return "";
  const auto end = [&](std::size_t k) { return fixed_text(j[key + "_95"][k].get<double>(), 2); };
  return end(0) + " … " + end(1);
}

std::string evaluation_table(const json& prediction) {
  std::vector<std::vector<std::string>> rows;
  const auto with_sd = [](const json& j, const std::string& key, const char* unit) {
    const auto value = number_at(j, {key});
    return value ? quantity(*value, number_at(j, {key + "_sd"}), unit) : "–";
  };
  for (const char* cut : kCuts) {
    if (!prediction.contains(cut) || !prediction[cut].contains("heights")) continue;
    const json& e = prediction[cut];
    for (const json& at : e["heights"]) {
      std::string center = "–";
      if (at.contains("center_um") && at["center_um"].size() == 2) {
        center.clear();
        for (std::size_t k = 0; k < 2; ++k)
          center +=
              (k == 0 ? "" : ", ") +
              quantity(at["center_um"][k].get<double>(),
                       at.contains("center_um_sd") ? std::optional(at["center_um_sd"][k].get<double>()) : std::nullopt,
                       k == 0 ? "" : "um");
      }
      rows.push_back({cut, quantity(at.value("h_mm", 0.0), std::nullopt, "mm"), with_sd(at, "lsc_um", "um"),
                      interval(at, "lsc_um"), with_sd(at, "mzc_um", "um"), center, with_sd(at, "diameter_mm", "mm")});
    }
  }
  std::vector<std::vector<std::string>> wholes;
  for (const char* cut : kCuts)
    if (prediction.contains(cut) && prediction[cut].is_object())
      wholes.push_back({cut, with_sd(prediction[cut], "rms_um", "um"), with_sd(prediction[cut], "form_um", "um"),
                        with_sd(prediction[cut], "half_angle_deg", "deg"),
                        with_sd(prediction[cut], "axis_tilt_urad", "urad")});
  return html_table("The piece by height (ISO 12181; with standard uncertainty)",
                    {"cut", "height", "roundness, LSC", "95 % of it, µm", "roundness, MZC", "centre x, y", "diameter"},
                    rows) +
         html_table("The piece as a whole (with standard uncertainty)",
                    {"cut", "deviation, rms", "form", "half angle", "axis tilt"}, wholes);
}

/// What the best compensation that was asked for makes of the roundness at the first height.
std::string sentence_of(const json& prediction) {
  const auto roundness = [&](const char* cut) -> std::string {
    if (!prediction.contains(cut) || !prediction[cut].contains("heights") || prediction[cut]["heights"].empty())
      return "";
    const json& at = prediction[cut]["heights"][0];
    const double value = at.value("lsc_um", 0.0);
    const std::string range = interval(at, "lsc_um");
    if (range.empty()) return "<strong>" + quantity(value, std::nullopt, "um") + "</strong>";
    // Draws about a piece that is nearly round are all less round than it: their upper end says what may be found.
    const bool above = value < at["lsc_um_95"][0].get<double>();
    return "<strong>" + fixed_text(value, 2) +
           "\u00a0µm</strong> (95 %: " + (above ? "up to " + fixed_text(at["lsc_um_95"][1].get<double>(), 2) : range) +
           ")";
  };
  std::string text = "A cone cut on this machine: roundness " + roundness("uncompensated") + " as it is";
  for (const auto& [cut, said] :
       {std::pair("tables", "under tables"), std::pair("corrected", "with its program corrected")})
    if (const std::string found = roundness(cut); !found.empty()) text += ", " + found + " " + said;
  return text + ".";
}

}  // namespace

Section piece_section(const Evidence& evidence) {
  Section section{"piece", "Test piece", ""};
  std::size_t number = 0;
  for (const ResultFile& r : evidence.results) {
    if (r.kind != ResultKind::prediction) continue;
    const json& prediction = *r.content;
    section.html += element("h3", escaped(r.path)) + evaluation_table(prediction);
    if (prediction.contains("notes") && !prediction["notes"].empty())
      section.html += element("p", "Note: " + word_list(prediction["notes"]) + ".", "class=\"warning\"");
    section.html += polar_plots(r.columns, prediction);
    if (const auto flank = flank_of(r.flank, prediction); flank && prediction.contains("piece"))
      section.html += part_view(*flank, prediction, ++number);
    section.sentence += (section.sentence.empty() ? "" : " ") + sentence_of(prediction);
  }
  return section.html.empty() ? Section{} : section;
}

}  // namespace trunnion
