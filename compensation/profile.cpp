#include "compensation/profile.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "error.h"

namespace trunnion {
namespace {

std::string shown(const ProfileValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return '"' + *text + '"';
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, std::get<double>(value)).ptr;
  return {buffer, end};
}

std::string wanted(const ProfileItem& item) {
  std::string text;
  for (const std::string& answer : item.answers) text += (text.empty() ? "\"" : ", \"") + answer + "\"";
  return text + " is wanted, followed by \" confirmed\" once it was seen on the machine";
}

bool allowed(const ProfileNumber& number, double value) {
  if (!(value >= number.low && value <= number.high)) return false;
  return number.step == 0 || std::fmod(value - number.low, number.step) == 0;
}

std::string wanted(const ProfileNumber& number) {
  if (number.step == number.high - number.low) return shown(number.low) + " or " + shown(number.high) + " is wanted";
  return std::string(number.step == 0 ? "a number" : "a whole number") + " from " + shown(number.low) + " to " +
         shown(number.high) + " is wanted";
}

}  // namespace

Profile::Profile(const Machine& machine, ProfileQuestions questions, Reversal reversal)
    : questions_(std::move(questions)) {
  constexpr std::string_view kConfirmed = "confirmed";
  for (const ProfileItem& item : questions_.items) {
    const auto found = machine.profile.find(item.key);
    std::string answer = item.answers.front();
    bool confirmed = false;
    if (found != machine.profile.end()) {
      const auto* text = std::get_if<std::string>(&found->second);
      if (text == nullptr)
        throw ModelError("profile." + item.key + ": " + shown(found->second) + " found, one of " + wanted(item));
      std::string said = *text;
      if (said == kConfirmed) {
        confirmed = true;
      } else {
        const std::size_t blank = said.rfind(' ');
        if (blank != std::string::npos && said.substr(blank + 1) == kConfirmed) confirmed = true, said.resize(blank);
        if (std::ranges::count(item.answers, said) == 0)
          throw ModelError("profile." + item.key + ": " + shown(found->second) + " found, one of " + wanted(item));
        answer = said;
      }
    }
    answers_[item.key] = answer;
    if (!confirmed && (!item.of_reversal || reversal == Reversal::some)) unconfirmed_.push_back(item);
  }
  for (const ProfileNumber& number : questions_.numbers) {
    double value = number.standard;
    if (const auto found = machine.profile.find(number.key); found != machine.profile.end()) {
      const auto* given = std::get_if<double>(&found->second);
      if (given == nullptr || !allowed(number, *given))
        throw ModelError("profile." + number.key + ": " + shown(found->second) + " found, " + wanted(number));
      value = *given;
    }
    numbers_[number.key] = value;
  }
}

}  // namespace trunnion
