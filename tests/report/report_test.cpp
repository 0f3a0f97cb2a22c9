#include <gmock/gmock.h>

#include <cmath>

#include "error.h"
#include "report/chart.h"
#include "report/evidence.h"

namespace trunnion {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

EvidenceFile model_file(const std::string& serial) {
  return {.path = "model.json",
          .text = std::string(R"({"format": "trunnion-model", "version": 1,
            "machine": {"name": "Mill <1>", "serial": ")" +
                              serial + R"("},
            "fit": {"readings": 219, "unknowns": 153, "reduced_chi2": 1.1, "program": "trunnion 0.1.0",
                    "inputs_sha256": {"o.csv": "abc123"},
                    "errors": {"EAA": {"largest": 35.2, "std": 0.56, "at": {"A_deg": -90}, "p_value": 0}}},
            "effects": [{"id": "rotary_error_map", "grid_deg": {"A": [-90, 0], "C": [0, 180]},
              "values": {"EAA": {"unit": "urad", "data": [35, 0]}, "EXC": {"unit": "um", "data": [[1, 2], [3, null]]}},
              "std": {"EAA": {"unit": "urad", "data": [0.5, 0.4]}}}]})")};
}

TEST(EvidencePage, ShowsWhatTheResultsHoldAndNothingOfTheNetwork) {
  EvidenceFile closure{
      .path = "closed/closure.json",
      .text = std::string(R"({"format": "trunnion-closure", "machine": {"name": "Mill <1>", "serial": "7"},
      "verdict": "explained", "noise_um": 0.175, "before": {"rms_um": 0.6, "holdout_rms_um": 0.5}, "after": {"rms_um": 0.17,
      "holdout_rms_um": null}, "effects": [{"id": "backlash:C", "origin": "machine", "depends_on": ["C_dir"], "p_value": 1e-30,
      "parameters": {"reversal": {"value": 25.5, "std": 0.24, "unit": "urad"}}, "compensated": true, "needs": [],
      "not_separable_from": ["thermal_drift"], "separate_by": "</script><b>", "alternatives": []}],
      "untestable": [{"id": "payload_sag", "separate_by": "a load"}]})"),
      .tables = {{"residuals.csv",
                  {{"time_s", {3, 1, 2}},
                   {"residual_before_um", {1, 2, std::nan("")}},
                   {"residual_after_um", {.1, .2, .3}}}}}};
  const std::string page = evidence_page({model_file("7"), closure});
  for (const char* shown :
       {"Mill &lt;1&gt;, serial 7", "35.20 +- 0.56", "Verdict: explained.", "25.50 +- 0.24", "abc123",
        "cannot tell it from thermal_drift", "payload_sag", "id=\"identification\"", "id=\"closure\"", "&lt;1e-16"})
    EXPECT_THAT(page, HasSubstr(shown));
  EXPECT_THAT(page, Not(HasSubstr("</script><b>")));  // neither as text nor inside the data
  EXPECT_THAT(page, Not(HasSubstr("id=\"piece\"")));
  for (const char* outside : {"src=\"", "href=\"http", "url(http", "@import", "nan"})
    EXPECT_THAT(page.substr(0, page.find("<script type")), Not(HasSubstr(outside))) << outside;
}

TEST(EvidencePage, IsOfOneMachine) {
  EXPECT_THAT(
      [] {
        evidence_page({model_file("7"), model_file("8")});
      },
      ::testing::ThrowsMessage<InputError>(HasSubstr("of machine 8, but model.json is of machine 7")));
}

TEST(EvidencePage, KnowsItsFilesByWhatTheySay) {
  EXPECT_EQ(evidence_kind(R"({"format": "trunnion-closure"})"), EvidenceKind::closure);
  EXPECT_EQ(evidence_kind(R"({"controller": "isg-twincat", "position_rms_um": {}})"), EvidenceKind::tables);
  EXPECT_EQ(evidence_kind(R"({"format": "else"})"), EvidenceKind::none);
  EXPECT_EQ(evidence_kind("no json"), EvidenceKind::none);
  EXPECT_EQ(evidence_kind("[1]"), EvidenceKind::none);
}

TEST(Chart, DrawsWithoutADotWhereNothingIs) {
  const Chart chart{.title = "t",
                    .x_label = "x",
                    .y_label = "y",
                    .x = {0, 1, 2},
                    .series = {{"a", {1, std::nan(""), 3}, {}}, {"b", {0, 0, 0}, {1, 1, 1}}}};
  const std::string svg = still_svg(chart);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, HasSubstr("polygon class=\"band s1\""));
  EXPECT_THAT(chart_json(chart), HasSubstr("[1.0,null,3.0]"));
  EXPECT_THAT(still_svg({.title = "flat", .x = {1}, .series = {{"", {0}, {}}}}), Not(HasSubstr("inf")));
}

}  // namespace
}  // namespace trunnion
