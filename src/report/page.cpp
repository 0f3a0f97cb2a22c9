#include "report/page.h"

extern "C" {
extern const char trunnion_report_css[], trunnion_report_css_end[];
extern const char trunnion_report_js[], trunnion_report_js_end[];
}

namespace trunnion {

void Page::section(const std::string& id, const std::string& heading, const std::string& lead) {
  if (open_) body_ += "</section>\n";
  open_ = true;
  contents_ += "<li><a href=\"#" + escaped(id) + "\">" + escaped(heading) + "</a></li>";
  body_ += "<section id=\"" + escaped(id) + "\" aria-labelledby=\"" + escaped(id) + "-h\"><h2 id=\"" + escaped(id) +
           "-h\">" + escaped(heading) + "</h2>";
  paragraph(lead, "lead");
}

void Page::heading(const std::string& text) { body_ += "<h3>" + escaped(text) + "</h3>"; }

void Page::paragraph(const std::string& text, const std::string& css_class) {
  if (!text.empty())
    body_ += "<p" + (css_class.empty() ? "" : " class=\"" + css_class + "\"") + ">" + escaped(text) + "</p>\n";
}

void Page::table(const std::vector<std::vector<std::string>>& rows, const std::string& caption) {
  if (rows.size() < 2) return;
  body_ += "<div class=\"scroll\" tabindex=\"0\" role=\"group\" aria-label=\"" + escaped(caption) +
           "\"><table><caption>" + escaped(caption) + "</caption><thead><tr>";
  for (const std::string& cell : rows.front()) body_ += "<th scope=\"col\">" + escaped(cell) + "</th>";
  body_ += "</tr></thead><tbody>";
  for (std::size_t r = 1; r < rows.size(); ++r) {
    body_ += "<tr>";
    for (std::size_t c = 0; c < rows[r].size(); ++c)
      body_ += (c == 0 ? "<th scope=\"row\">" : "<td>") + escaped(rows[r][c]) + (c == 0 ? "</th>" : "</td>");
    body_ += "</tr>";
  }
  body_ += "</tbody></table></div>\n";
}

void Page::charts(const std::vector<Chart>& charts) {
  body_ += "<div class=\"charts\">";
  for (const Chart& chart : charts) {
    body_ += "<figure><figcaption>" + escaped(chart.title) +
             "</figcaption><div class=\"chart\" tabindex=\"0\" data-chart=\"" + std::to_string(charts_.size()) + "\">" +
             still_svg(chart) + "</div>";
    if (chart.series.size() > 1) {
      body_ += "<ul class=\"key\">";
      for (std::size_t i = 0; i < chart.series.size(); ++i)
        body_ += "<li class=\"s" + std::to_string(i % 8) + "\">" + escaped(chart.series[i].name) + "</li>";
      body_ += "</ul>";
    }
    body_ += "</figure>";
    charts_.push_back(chart_json(chart));
  }
  body_ += "</div>\n";
}

void Page::picture(const std::string& svg, const std::string& caption) {
  body_ += "<figure class=\"picture\">" + svg + "<figcaption>" + escaped(caption) + "</figcaption></figure>\n";
}

void Page::part(const std::string& part, const std::string& still) {
  body_ +=
      "<figure class=\"part\" data-part=\"" + std::to_string(parts_.size()) + "\"><div class=\"view\">" + still +
      "</div><figcaption>The flank as it is cut, coloured by its deviation along the normal</figcaption></figure>\n";
  parts_.push_back(part);
}

std::string Page::html() const {
  const auto listed = [](const std::vector<std::string>& entries) {
    std::string list;
    for (const std::string& entry : entries) list += (list.empty() ? "" : ",") + entry;
    return "[" + list + "]";
  };
  std::string data = "{\"charts\":" + listed(charts_) + ",\"parts\":" + listed(parts_) + "}";
  // Inside a script element only "</" would end it.
  for (std::size_t at = 0; (at = data.find("</", at)) != std::string::npos; at += 3) data.replace(at, 2, "<\\/");
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
         "content=\"width=device-width,initial-scale=1\"><title>" +
         escaped(title_) + "</title><style>" + std::string(trunnion_report_css, trunnion_report_css_end) +
         "</style></head><body><header><h1>" + escaped(title_) + "</h1><nav aria-label=\"Sections\"><ul>" + contents_ +
         "</ul></nav></header><main>" + body_ + (open_ ? "</section>" : "") +
         "</main><script type=\"application/json\" id=\"data\">" + data + "</script><script>" +
         std::string(trunnion_report_js, trunnion_report_js_end) + "</script></body></html>\n";
}

}  // namespace trunnion
