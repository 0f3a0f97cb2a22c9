#include "report/page.h"

#include "report/html.h"
#include "report/sections.h"
#include "report/web_assets.h"

namespace trunnion {
namespace {

std::string head(const std::string& title) {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<meta name=\"color-scheme\" content=\"light dark\">\n"
         // Nothing is fetched, whatever stands in the page.
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
         "style-src 'unsafe-inline'; img-src data: blob:\">\n"
         "<title>" +
         escaped(title) + "</title>\n<style>\n" + std::string(page_style()) + "</style>\n</head>\n";
}

std::string whole_section(const Section& section) {
  return element("section", element("h2", escaped(section.title), "id=\"" + section.id + "-title\"") + section.html,
                 "id=\"" + section.id + "\" aria-labelledby=\"" + section.id + "-title\"");
}

}  // namespace

std::string page_html(const Evidence& evidence) {
  std::string title = "Rotary-axis errors";
  if (const std::string machine = machine_name(evidence); !machine.empty()) title += ": " + machine;
  std::string links, summary, body;
  for (const auto& make : {identification_section, interpolation_section, closure_section, compensation_section,
                           program_section, piece_section, provenance_section}) {
    const Section section = make(evidence);
    if (section.html.empty()) continue;
    links += element("li", element("a", escaped(section.title), "href=\"#" + section.id + "\""));
    if (!section.sentence.empty())
      summary += element(
          "li", element("a", escaped(section.title), "href=\"#" + section.id + "\"") + element("p", section.sentence));
    body += whole_section(section);
  }
  std::string html = head(title) + "<body>\n<a class=\"skip\" href=\"#summary\">Skip to the summary</a>\n";
  html +=
      element("header", element("h1", escaped(title)) +
                            element("p", "What is wrong with the machine, what was done about it, and what is left. " +
                                             escaped(evidence.program) + ", " + escaped(evidence.date)) +
                            element("nav", element("ul", links), "aria-label=\"Sections\"") +
                            "<button type=\"button\" id=\"theme\" hidden>Light or dark</button>\n");
  html += element(
      "main", element("section",
                      element("h2", "In short", "id=\"summary-title\"") + element("ul", summary, "class=\"findings\""),
                      "id=\"summary\" aria-labelledby=\"summary-title\"") +
                  body);
  html += element("footer", element("p",
                                    "± is one standard uncertainty (ISO/IEC Guide 98-3). Error symbols: ISO 230-1 and "
                                    "230-7. Charts and part: uPlot and three.js, within this file.") +
                                element("details", element("summary", "Licences of the libraries in this file") +
                                                       element("pre", escaped(page_licences()))));
  return html + element("script", std::string(page_script())) + "</body>\n</html>\n";
}

}  // namespace trunnion
