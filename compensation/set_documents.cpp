#include "compensation/set_documents.h"

#include <algorithm>

namespace trunnion {
namespace {

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

/// `text` with the tilting axis' letter for {A}, and every file called as it is in the folder.
std::string of_this_set(std::string text, const SetDocuments& set) {
  text = replaced(text, "{A}", std::string(1, set.task.machine.tilt_letter()));
  for (const std::vector<TableFile>* files : {&set.tables, &set.commissioning})
    for (const TableFile& file : *files)
      text = replaced(text, '`' + final_name(file.name) + '`', '`' + file.name + '`');
  return text;
}

/// The files of a draft that cannot say in themselves what they are.
std::string silent_files(const SetDocuments& set) {
  std::string names;
  for (const std::vector<TableFile>* files : {&set.tables, &set.commissioning})
    for (const TableFile& file : *files)
      if (std::ranges::any_of(set.controller.no_comments,
                              [&](std::string_view end) { return final_name(file.name).ends_with(end); }))
        names += (names.empty() ? "`" : ", `") + file.name + '`';
  return names;
}

std::string draft_text(const SetDocuments& set) {
  std::string text =
      "\n**NOT LOAD-READY.** These files are drafts: no public document settles what follows, and a wrong sign "
      "doubles\n"
      "the error. Do the commissioning test, write the answer into the machine file's [profile], make the tables "
      "again.\n"
      "The first lines of each file say so";
  const std::string silent = silent_files(set);
  text += silent.empty() ? ".\n" : "; these take no comments, and only their names say DRAFT: " + silent + ".\n";
  for (const ProfileItem& item : set.task.profile.unconfirmed())
    text += "\n- `" + item.key + "`: " + item.question + " Assumed: \"" + set.task.profile.answer(item.key) +
            "\".\n  Test: " + item.test + "\n";
  return text;
}

}  // namespace

std::string draft_name(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  const std::size_t dot = name.find('.', slash == std::string::npos ? 0 : slash);
  return dot == std::string::npos ? name + ".DRAFT" : name.substr(0, dot) + ".DRAFT" + name.substr(dot);
}

std::string final_name(std::string name) {
  const std::size_t at = name.find(".DRAFT");
  if (at != std::string::npos) name.erase(at, 6);
  return name;
}

std::string loading_text(const SetDocuments& set) {
  std::string text = "# Loading this compensation: " + std::string(set.controller.title) + "\n\nMade for " +
                     provenance(set.task) + ".\n";
  if (!set.verification.load_ready()) text += draft_text(set);
  text += "\n## What it does\n\n```\n" + verification_text(set.verification, set.task.machine) + "```\n";
  if (!set.controller.cannot_hold.empty())
    text += "\nWhat this control cannot hold: " + std::string(set.controller.cannot_hold) + "\n";
  return of_this_set(text + "\n" + set.controller.loading(set.task, set.tables), set);
}

std::string commissioning_text(const SetDocuments& set) {
  std::string text = "# Commissioning tests\n\nFor " + provenance(set.task) +
                     ". One at a time, each with every other compensation switched off.\n";
  for (const ProfileItem& item : set.task.profile.unconfirmed()) {
    text += "\n## " + item.key + "\n\n" + item.question + "\n\n" + item.test +
            "\n\nEnter the answer in the machine file:\n\n```toml\n[profile]\n";
    for (const std::string& answer : item.answers) text += "# " + item.key + " = \"" + answer + " confirmed\"\n";
    text += "```\n";
  }
  if (!set.commissioning.empty()) {
    text += "\nSmall tables for these tests, one peak of 20 um, 0.005 deg or seven pulses each:\n\n";
    for (const TableFile& file : set.commissioning) text += "- `" + file.name + "`\n";
  }
  return of_this_set(text, set);
}

}  // namespace trunnion
