#pragma once

#include <map>
#include <string>
#include <vector>

#include "kinematics/machine.h"

namespace trunnion {

/// A fact about a control that no public document settles: a sign, an order of indices, a rule. The machine file's
/// [profile] answers it by one of `answers`, followed by `confirmed` once it was seen on the machine:
///   cec_sign = "add confirmed"      or, for the first answer,      cec_sign = "confirmed"
struct ProfileItem {
  std::string key;
  std::string question;              ///< one sentence for people
  std::vector<std::string> answers;  ///< the first is what is believed
  std::string test;                  ///< what to move and what to read to find out
  bool of_reversal = false;          ///< matters only where values differ with the sense of motion
};

/// A number of the profile with the value that stands for it where the file is silent.
struct ProfileNumber {
  std::string key;
  std::string meaning;
  double standard = 0;
  double low = 0, high = 0;  ///< what it may be
  double step = 0;           ///< from `low` on: 1 for what is counted, 2 for -1 or 1, 0 for anything between
};

/// Whether a set holds values that differ with the sense of motion.
enum class Reversal { none, some };

/// What one controller asks its profile.
struct ProfileQuestions {
  std::vector<ProfileItem> items;
  std::vector<ProfileNumber> numbers;
};

/// The answers of one machine.
class Profile {
 public:
  /// Throws ModelError naming the key for an answer that is none of those wanted. Keys nobody asks for may belong to
  /// another controller. Questions of reversal need no confirmation where there is none.
  Profile(const Machine& machine, ProfileQuestions questions, Reversal reversal = Reversal::some);

  const std::string& answer(const std::string& key) const { return answers_.at(key); }
  double number(const std::string& key) const { return numbers_.at(key); }
  /// The items not yet confirmed on the machine, in order.
  std::vector<ProfileItem> unconfirmed() const { return unconfirmed_; }
  bool load_ready() const { return unconfirmed_.empty(); }
  const ProfileQuestions& questions() const { return questions_; }

 private:
  ProfileQuestions questions_;
  std::map<std::string, std::string> answers_;
  std::map<std::string, double> numbers_;
  std::vector<ProfileItem> unconfirmed_;
};

}  // namespace trunnion
