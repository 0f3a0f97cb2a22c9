#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "error.h"
#include "report/chart.h"
#include "report/page.h"

namespace trunnion {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

ResultFile result(ResultKind kind, const std::string& path, const std::string& text) {
  ResultFile file{.kind = kind, .path = path, .sha256 = std::string(64, 'a'), .changed = "2026-03-01"};
  file.content = std::make_shared<nlohmann::json>(nlohmann::json::parse(text));
  return file;
}

ResultFile model_file(const std::string& serial) {
  return result(
      ResultKind::model, "model.json",
      R"({"format": "trunnion-model", "version": 1, "machine": {"name": "Mill <1>", "serial": ")" + serial +
          R"("}, "fit": {"readings": 219, "unknowns": 153, "reduced_chi2": 1.1, "chi2_p": 0.2468, "program": "trunnion 0.1.0",
                    "inputs_sha256": {"o.csv": "abc123"},
                    "errors": {"EAA": {"largest": 35.2, "std": 0.56, "unit": "urad", "at": {"A_deg": -90}, "p_value": 0}}},
            "effects": [{"id": "rotary_error_map", "grid_deg": {"A": [-90, 0], "C": [0, 180]},
              "values": {"EAA": {"unit": "urad", "data": [35, 0]}, "EXC": {"unit": "um", "data": [[1, 2], [3, null]]}},
              "std": {"EAA": {"unit": "urad", "data": [0.5, 0.4]}}}]})");
}

std::string page_of(std::vector<ResultFile> results) {
  return page_html({.results = std::move(results), .program = "trunnion 0.1.0", .date = "2026-03-02"});
}

/// The page without its own script and the scripts' data.
std::string markup(std::string page) {
  for (std::size_t at = page.find("<script"); at != std::string::npos; at = page.find("<script"))
    page.erase(at, page.find("</script>", at) + 9 - at);
  return page;
}

TEST(EvidencePage, ShowsWhatTheResultsHoldAndNothingOfTheNetwork) {
  ResultFile closure = result(ResultKind::closure, "closed/closure.json",
                              R"({"format": "trunnion-closure", "machine": {"name": "Mill <1>", "serial": "7"},
      "verdict": "explained", "noise_um": 0.175, "before": {"rms_um": 0.6, "holdout_rms_um": 0.5}, "after": {"rms_um": 0.17,
      "holdout_rms_um": null}, "effects": [{"id": "backlash:C", "origin": "machine", "depends_on": ["C_dir"], "p_value": 1e-30,
      "parameters": {"reversal": {"value": 25.5, "std": 0.24, "unit": "urad"}}, "compensated": true, "needs": ["C_dir"],
      "not_separable_from": ["thermal_drift"], "separate_by": "</script><b>", "alternatives": []}],
      "untestable": [{"id": "payload_sag", "separate_by": "a load"}]})");
  closure.columns = {{"time_s", {3, 1, 2}},
                     {"<b>", {1, 2, 3}},
                     {"residual_before_um", {1, 2, std::nan("")}},
                     {"residual_after_um", {.1, .2, .3}}};
  const std::string page = page_of({model_file("7"), closure}), seen = markup(page);
  for (const char* shown : {"Mill &lt;1&gt;, serial 7", "35.20 ± 0.56", "Verdict: explained.", "25.50 ± 0.24", "abc123",
                            "thermal_drift", "payload_sag", "id=\"identification\"", "id=\"closure\"", "&lt;1e−16",
                            "(p 0.25)", "where known: C_dir", "Residual over time", "2026-03-01"})
    EXPECT_THAT(seen, HasSubstr(shown));
  EXPECT_THAT(page, Not(HasSubstr("</script><b>")));  // neither as text nor inside the data
  EXPECT_THAT(page, Not(HasSubstr("\"<b>\"")));
  EXPECT_THAT(seen, Not(HasSubstr("id=\"piece\"")));
  for (const char* outside : {"src=\"", "href=\"http", "url(http", "@import", ">nan", " nan"})
    EXPECT_THAT(seen, Not(HasSubstr(outside))) << outside;
}

TEST(EvidencePage, ShowsTheResidualOfEachSpotAndOfEachSenseOfMotionSideBySide) {
  ResultFile closure = result(ResultKind::closure, "closed/closure.json",
                              R"({"format": "trunnion-closure", "machine": {"name": "Mill <1>", "serial": "7"},
      "verdict": "nothing missing", "noise_um": 0.175})");
  closure.columns = {{"point", {std::nan(""), std::nan(""), std::nan(""), std::nan("")}},
                     {"C_dir", {1, -1, 1, -1}},
                     {"repeat", {0, 0, 0, 0}},
                     {"residual_before_um", {1, 2, 3, 4}},
                     {"residual_after_um", {.1, .2, .3, .4}}};
  closure.labels = {{"point", {"1T1", "1S<1>", "1T1", "1S<1>"}}};
  const std::string page = page_of({model_file("7"), closure}), seen = markup(page);
  EXPECT_THAT(seen, HasSubstr("Residual over spot"));
  EXPECT_THAT(seen, HasSubstr(">1S&lt;1&gt;</text>"));
  EXPECT_THAT(seen, HasSubstr("Residual over sense of C"));
  EXPECT_THAT(seen, Not(HasSubstr("Residual over pass")));  // one kind tells nothing
  // By kinds in the order of the alphabet, those of a kind in the order taken: 2 and 4 before 1 and 3.
  EXPECT_THAT(page, HasSubstr("\"values\":[2.0,4.0,1.0,3.0]"));
  EXPECT_THAT(page, HasSubstr("\"x\":[-0.32,0.32,0.68,1.32]"));
}

TEST(EvidencePage, ShowsLimitsMetLimitsUsedAndWhatWasLeftUncorrected) {
  const ResultFile correction =
      result(ResultKind::correction, "blade/correction.json",
             R"({"format": "trunnion-correction", "machine": {"name": "Mill <1>", "serial": "7"},
      "nc_program": "blade.ngc", "lines": 94, "blocks_beyond_tolerance": 2,
      "refused": [{"line": 31, "reason": "A 12 deg is <beyond> what was probed"}],
      "playback": {"before": {"position_rms_um": 4.4}, "after": {"position_rms_um": 0.05}, "refused_blocks": 5,
        "copied_from_line": 80, "limits": [
          {"limit": "axis.X.range_mm", "unit": "mm", "used": [-7.26, 28.04], "allowed": [-400, 400], "lines": [56, 29]},
          {"limit": "limits.correction_um", "unit": "um", "used": 5.8948, "allowed": 200, "line": 54}]}})");
  const std::string seen = markup(page_of({model_file("7"), correction}));
  for (const char* shown :
       {"<code>axis.X.range_mm</code>", "−7.26 … 28.0\u00a0mm", "−400 … 400\u00a0mm", ">56, 29<", "5.89\u00a0µm",
        "200\u00a0µm", ">54<", "5 refused blocks are copied as they were, and everything from line 80 on",
        "A 12 deg is &lt;beyond&gt; what was probed", "In 2 blocks the tip is further off"})
    EXPECT_THAT(seen, HasSubstr(shown));
  const ResultFile whole =
      result(ResultKind::correction, "blade/correction.json",
             R"({"machine": {"name": "Mill <1>", "serial": "7"}, "nc_program": "blade.ngc", "lines": 94,
      "refused": [], "blocks_beyond_tolerance": 0, "playback": {"refused_blocks": 0, "copied_from_line": 0, "limits": []}})");
  const std::string clean = markup(page_of({model_file("7"), whole}));
  for (const char* absent : {"copied as they were", "Limits:", "further off", "Refused blocks"})
    EXPECT_THAT(clean, Not(HasSubstr(absent)));
}

TEST(EvidencePage, TellsRoundnessInTheDigitsOfItsInterval) {
  const ResultFile prediction =
      result(ResultKind::prediction, "piece/prediction.json",
             R"({"format": "trunnion-prediction", "machine": {"name": "Mill <1>", "serial": "7"},
      "uncompensated": {"heights": [{"h_mm": 2, "lsc_um": 3.6683, "lsc_um_95": [3.4623, 3.8578]}]},
      "corrected": {"heights": [{"h_mm": 2, "lsc_um": 0.0254, "lsc_um_95": [0.0721, 0.3094]}]}})");
  const std::string seen = markup(page_of({model_file("7"), prediction}));
  EXPECT_THAT(seen, HasSubstr("<strong>3.67\u00a0µm</strong> (95 %: 3.46 … 3.86) as it is"));
  EXPECT_THAT(seen, HasSubstr("<strong>0.03\u00a0µm</strong> (95 %: up to 0.31) with its program corrected"));
}

TEST(EvidencePage, SaysWhereNoSigmaIsDeclared) {
  ResultFile model = model_file("7");
  EXPECT_THAT(markup(page_of({model})), HasSubstr("1.10 (p 0.25): as declared"));
  nlohmann::json content = *model.content;
  content["fit"]["sigma_found_um"] = 0.71;
  content["fit"]["sigma_declared_um"] = nullptr;
  model.content = std::make_shared<const nlohmann::json>(std::move(content));
  const std::string seen = markup(page_of({model}));
  EXPECT_THAT(seen, HasSubstr("0.710\u00a0µm, none"));
  EXPECT_THAT(seen, HasSubstr("1.10 (p 0.25): by construction"));
}

TEST(EvidencePage, IsOfOneMachine) {
  EXPECT_THAT(([] {
                page_of({model_file("7"), model_file("8")});
              }),
              ::testing::ThrowsMessage<RefusalError>(
                  HasSubstr("of Mill <1>, serial 8, but model.json is of Mill <1>, serial 7")));
}

TEST(EvidencePage, SaysWhereResultsWereMadeFromDifferentFilesOfOneName) {
  ResultFile other = result(ResultKind::tables, "tables/verification.json",
                            R"({"controller": "heidenhain", "lost_to": {}, "inputs_sha256": {"o.csv": "def456"}})");
  EXPECT_THAT(page_of({model_file("7"), other}), HasSubstr("made from 2 different files named o.csv"));
  EXPECT_THAT(page_of({model_file("7")}), Not(HasSubstr("different files")));
}

TEST(Chart, DrawsNothingWhereNothingIs) {
  const std::string figure = chart_figure({.title = "t",
                                           .x_label = "x, mm",
                                           .y_label = "y, um",
                                           .x_name = "x",
                                           .y_unit = "um",
                                           .x = {0, 1, 2},
                                           .series = {{"a", {1, std::nan(""), 3}}, {"b", {0, 0, 0}, {1, 1, 1}}}});
  EXPECT_THAT(figure, Not(HasSubstr("nan")));
  EXPECT_THAT(figure, HasSubstr("class=\"band s1\""));
  EXPECT_THAT(figure, Not(HasSubstr("class=\"band s0\"")));
  EXPECT_THAT(figure, HasSubstr("[1.0,null,3.0]"));
  const std::string flat =
      chart_figure({.title = "flat", .x_label = "x, mm", .y_label = "y, um", .x = {1}, .series = {{"", {0}}}});
  EXPECT_THAT(flat, Not(HasSubstr("inf")));
  EXPECT_THAT(flat, Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace trunnion
