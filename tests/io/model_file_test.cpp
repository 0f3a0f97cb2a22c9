#include "io/model_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "error.h"
#include "identification/identify.h"
#include "io/machine_file.h"
#include "io/observation_file.h"
#include "io/sha256.h"
#include "io/text_file.h"

namespace trunnion {
namespace {

const Machine kModelled = read_machine(TRUNNION_SOURCE_DIR "/tests/rejected/shared/machine.toml");
const std::string kModel = read_text(TRUNNION_SOURCE_DIR "/tests/rejected/shared/model.json");

TEST(ModelFile, ReadsBackWhatItWrote) {
  const Model model = parse_model(kModel, "model.json", kModelled);
  const std::string written = model_text(model);
  EXPECT_EQ(model_text(parse_model(written, "model.json", kModelled)), written);
}

TEST(ModelFile, CarriesTheFitAlong) {
  nlohmann::json document = nlohmann::json::parse(kModel);
  document["fit"] = {{"sigma_um", 0.175}, {"outliers", {3, 4}}};
  const Model model = parse_model(document.dump(), "model.json", kModelled);
  EXPECT_EQ(nlohmann::json::parse(model_text(model))["fit"], document["fit"]);
}

TEST(ModelFile, WritesNumbersInShortestFormAndListsOnOneLine) {
  const std::string written = model_text(parse_model(kModel, "model.json", kModelled));
  EXPECT_NE(written.find("[0.1, 0.2, -0.3]"), std::string::npos) << written;
}

/// Constants that no pose shows are uncertain by meters; in the seven digits of a file they must not touch the rest.
TEST(ModelFile, KeepsTheUncertaintyOfAnIdentifiedModel) {
  constexpr double kSevenDigits_mm = 1e-8;  // on 0.3 um
  const std::string samples = TRUNNION_SOURCE_DIR "/samples/calibrate/";
  const Machine machine = read_machine(samples + "machine.toml");
  const ObservationSet observations = read_observations(samples + "replica.csv", machine);
  const Model model = identify(observations, machine, {.interpolation = "gaussian-process"}).model;
  const Model read = parse_model(model_text(model), "model.json", machine);
  for (const double a_deg : {-90.0, -75.0, -60.0, -15.0})
    for (const double c_deg : {0.0, 90.0, 200.0}) {
      Situation s;
      s.at = {Angle::degrees(a_deg), Angle::degrees(c_deg)};
      s.point_r_mm = {80, -40, 100};
      EXPECT_NEAR(std::sqrt(deviation_covariance_mm2(read, s).trace()),
                  std::sqrt(deviation_covariance_mm2(model, s).trace()), kSevenDigits_mm)
          << "A " << a_deg << " C " << c_deg;
    }
}

TEST(ModelFile, RefusesTheModelOfAnotherSerialNumber) {
  Machine other = kModelled;
  other.serial = "R-9";
  EXPECT_THROW(parse_model(kModel, "model.json", other), RefusalError);
}

TEST(Sha256, GivesTheDigestsOfTheStandard) {  // FIPS 180-4's own examples: "abc", and 448 bits
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

}  // namespace
}  // namespace trunnion
