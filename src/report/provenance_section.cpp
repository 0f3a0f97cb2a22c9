#include <nlohmann/json.hpp>
#include <set>

#include "error.h"
#include "report/html.h"
#include "report/sections.h"

namespace trunnion {
namespace {

std::string kind_text(ResultKind kind) {
  switch (kind) {
    case ResultKind::model:
      return "model";
    case ResultKind::closure:
      return "closure";
    case ResultKind::tables:
      return "tables";
    case ResultKind::correction:
      return "program correction";
    case ResultKind::prediction:
      return "test piece";
  }
  return "";
}

/// A path that a narrow window may break after its folders.
std::string path_text(const std::string& path) {
  std::string text;
  for (const char c : path) text += c == '/' ? "/<wbr>" : escaped(std::string(1, c));
  return text;
}

std::string hash_text(const std::string& digits) {
  return "<code title=\"" + escaped(digits) + "\">" + escaped(digits.substr(0, 12)) + "</code>";
}

const nlohmann::json& provenance_of(const ResultFile& result) {
  const nlohmann::json& content = *result.content;
  return result.kind == ResultKind::model && content.contains("fit") && content["fit"].is_object() ? content["fit"]
                                                                                                   : content;
}

std::string machine_text(const nlohmann::json& content) {
  if (!content.contains("machine") || !content["machine"].is_object()) return "";
  const nlohmann::json& machine = content["machine"];
  const std::string serial = text_at(machine, "serial");
  return text_at(machine, "name", "no name") + (serial.empty() ? "" : ", serial " + serial);
}

/// Every input that a result names with its hash.
std::vector<std::vector<std::string>> input_rows(const Evidence& evidence) {
  std::set<std::string> model_hashes;
  for (const ResultFile& r : evidence.results)
    if (r.kind == ResultKind::model) model_hashes.insert(r.sha256);
  std::vector<std::vector<std::string>> rows;
  for (const ResultFile& r : evidence.results) {
    const nlohmann::json& provenance = provenance_of(r);
    if (!provenance.contains("inputs_sha256") || !provenance["inputs_sha256"].is_object()) continue;
    for (const auto& [name, hash] : provenance["inputs_sha256"].items()) {
      const std::string digits = hash.is_string() ? hash.get<std::string>() : "";
      rows.push_back({path_text(r.path), escaped(name), digits.empty() ? "not a file" : hash_text(digits),
                      model_hashes.contains(digits) ? "the model on this page" : ""});
    }
  }
  return rows;
}

/// What does not belong together, as warnings.
std::string contradictions(const Evidence& evidence) {
  std::map<std::string, std::set<std::string>> hashes;
  for (const ResultFile& r : evidence.results) {
    const nlohmann::json& provenance = provenance_of(r);
    if (provenance.contains("inputs_sha256") && provenance["inputs_sha256"].is_object())
      for (const auto& [name, hash] : provenance["inputs_sha256"].items())
        if (hash.is_string()) hashes[name].insert(hash.get<std::string>());
  }
  std::string text;
  for (const auto& [name, digits] : hashes)
    if (digits.size() > 1)
      text += element("p",
                      "The results were made from " + std::to_string(digits.size()) + " different files named " +
                          escaped(name) + "; see the hashes below.",
                      "class=\"warning\"");
  return text;
}

}  // namespace

std::string machine_name(const Evidence& evidence) {
  const ResultFile* first = nullptr;
  for (const ResultFile& r : evidence.results) {
    const std::string machine = machine_text(*r.content);
    if (machine.empty()) continue;
    if (first == nullptr) first = &r;
    if (const std::string known = machine_text(*first->content); machine != known)
      throw RefusalError(r.path + ": of " + machine + ", but " + first->path + " is of " + known +
                         "; one page for each machine is wanted");
  }
  return first == nullptr ? "" : machine_text(*first->content);
}

Section provenance_section(const Evidence& evidence) {
  std::vector<std::vector<std::string>> files;
  std::string structure;
  for (const ResultFile& r : evidence.results) {
    files.push_back({path_text(r.path), kind_text(r.kind), hash_text(r.sha256), escaped(r.changed),
                     escaped(text_at(provenance_of(r), "program", "not said"))});
    if (r.kind == ResultKind::model && r.content->contains("machine"))
      structure = text_at((*r.content)["machine"], "structure", structure);
  }
  std::string facts;
  if (const std::string machine = machine_name(evidence); !machine.empty())
    facts += element("dt", "Machine") + element("dd", escaped(machine));
  if (!structure.empty())
    facts += element("dt", "Structure, workpiece to tool (ISO 10791-6)") + element("dd", escaped(structure));
  facts += element("dt", "Page") + element("dd", escaped(evidence.program) + ", " + escaped(evidence.date));
  std::string html = contradictions(evidence) + element("dl", facts, "class=\"facts\"");
  html += html_table("Results on this page", {"file", "what", "SHA-256", "last changed", "made by"}, files);
  if (const auto rows = input_rows(evidence); !rows.empty())
    html += html_table("What they were made from", {"result", "input", "SHA-256", ""}, rows);
  return {"data", "Machine and data", html};
}

}  // namespace trunnion
