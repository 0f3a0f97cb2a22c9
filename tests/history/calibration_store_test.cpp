#include "history/calibration_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "error.h"
#include "history/schema.h"

namespace trunnion {
namespace {

using ::testing::HasSubstr;

/// Where a test keeps its calibrations: an SQLite file in a folder of its own, or a schema of its own in the database
/// that TRUNNION_TEST_POSTGRES names.
class Place {
 public:
  explicit Place(bool postgres) {
    static int count = 0;
    if (!postgres) {
      folder_ = std::filesystem::path(::testing::TempDir()) /
                ("history_" + std::to_string(::getpid()) + "_" + std::to_string(++count));
      std::filesystem::create_directories(folder_);
      store_ = (folder_ / "shop.db").string();
      return;
    }
    const std::string uri = std::getenv("TRUNNION_TEST_POSTGRES");
    const std::string schema = "t" + std::to_string(::getpid()) + "_" + std::to_string(++count);
    open_postgres(uri)->run("CREATE SCHEMA " + schema);
    store_ = uri + (uri.find('?') == std::string::npos ? "?" : "&") + "options=-csearch_path%3D" + schema;
  }
  ~Place() {
    if (!folder_.empty()) std::filesystem::remove_all(folder_);
  }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;

  const std::string& store() const { return store_; }
  std::unique_ptr<Database> database() const { return open_database(store_, OpenFor::adding); }
  CalibrationStore calibrations() const { return CalibrationStore(database()); }

 private:
  std::filesystem::path folder_;
  std::string store_;
};

Calibration calibration(const std::string& serial, const std::string& date, const std::string& model) {
  return {.machine = {.name = "Mill \"é\" '", .serial = serial, .structure = "w C' A' Y' b X Z t"},
          .taken = date,
          .model_sha256 = "hash of " + model.substr(0, 8),
          .note = "a\nnote",
          .closure = R"({"verdict": "explained"})",
          .inputs = {{"a.csv", "12"}, {"m.toml", "34"}},
          .machine_file = "name = 'x'",
          .model = model};
}

class Stores : public ::testing::TestWithParam<bool> {};

TEST_P(Stores, GiveBackWhatWasAdded) {
  const Place place(GetParam());
  const Calibration c = calibration("7", "2026-03-01T00:00:00Z", "{\"large\": \"" + std::string(300000, 'x') + "\"}");
  EXPECT_EQ(place.calibrations().add(c).id, 1);
  const Calibration back = place.calibrations().get(1);
  EXPECT_EQ(back.machine, c.machine);
  EXPECT_EQ(back.taken, c.taken);
  EXPECT_EQ(back.model, c.model);
  EXPECT_EQ(back.machine_file, c.machine_file);
  EXPECT_EQ(back.closure, c.closure);
  EXPECT_EQ(back.note, c.note);
  EXPECT_EQ(back.inputs, c.inputs);
}

TEST_P(Stores, ListByMachineAndDateWhateverTheOrderOfAdding) {
  const Place place(GetParam());
  CalibrationStore store = place.calibrations();
  store.add(calibration("b", "2026-03-01T00:00:00Z", "3"));
  store.add(calibration("B", "2026-01-01T00:00:00Z", "2"));
  store.add(calibration("b", "2025-03-01T00:00:00Z", "1"));
  std::vector<std::string> order;
  for (const Calibration& c : store.list({})) order.push_back(c.model_sha256);
  EXPECT_EQ(order, (std::vector<std::string>{"hash of 2", "hash of 1", "hash of 3"}));
  EXPECT_EQ(store.list("b").size(), 2U);
  EXPECT_TRUE(store.list("none").empty());
}

TEST_P(Stores, TakeTheSameCalibrationOnce) {
  const Place place(GetParam());
  CalibrationStore store = place.calibrations();
  store.add(calibration("7", "2026-03-01T00:00:00Z", "1"));
  store.add(calibration("7", "2026-04-01T00:00:00Z", "2"));
  const CalibrationStore::Added again = store.add(calibration("7", "2026-03-01T00:00:00Z", "1"));
  EXPECT_TRUE(again.stood_already);
  EXPECT_EQ(again.id, 1);
  EXPECT_EQ(store.list({}).size(), 2U);
  EXPECT_THROW(store.add(calibration("7", "2026-05-01T00:00:00Z", "1")), InputError);
}

TEST_P(Stores, RefuseAnotherMachineUnderTheSameSerialNumber) {
  const Place place(GetParam());
  CalibrationStore store = place.calibrations();
  store.add(calibration("7", "2026-03-01T00:00:00Z", "1"));
  Calibration other = calibration("7", "2026-04-01T00:00:00Z", "2");
  other.machine.name = "Lathe";
  EXPECT_THROW(store.add(other), RefusalError);
  other.machine.name = "Mill \"é\" '";
  other.machine.structure = "w C' B' Y' b X Z t";
  EXPECT_THROW(store.add(other), RefusalError);
  EXPECT_EQ(store.list({}).size(), 1U) << "a refusal leaves nothing";
}

TEST_P(Stores, NameTheCalibrationThatIsNotThere) {
  const Place place(GetParam());
  try {
    place.calibrations().get(41);
    FAIL() << "a calibration that nobody added";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("holds no calibration 41"));
  }
}

/// What version 1 of the tables looked like, with a calibration in them, as a database of that time holds it.
const std::vector<std::string> kVersion1 = {
    "CREATE TABLE trunnion_schema (version INTEGER NOT NULL)",
    "INSERT INTO trunnion_schema VALUES (1)",
    "CREATE TABLE trunnion_calibration (id BIGINT PRIMARY KEY, serial TEXT NOT NULL, machine_name TEXT NOT NULL, "
    "structure TEXT NOT NULL, taken TEXT NOT NULL, machine_file TEXT NOT NULL, model TEXT NOT NULL, "
    "model_sha256 TEXT NOT NULL, UNIQUE (serial, model_sha256))",
    "CREATE TABLE trunnion_input (calibration BIGINT NOT NULL REFERENCES trunnion_calibration (id), "
    "name TEXT NOT NULL, sha256 TEXT NOT NULL, PRIMARY KEY (calibration, name))",
    "INSERT INTO trunnion_calibration VALUES (3, '7', 'Mill', 'w C A', '2025-01-01T00:00:00Z', 'file', 'model', 'sum')",
    "INSERT INTO trunnion_input VALUES (3, 'old.csv', 'digits')",
};

TEST_P(Stores, BringVersion1UpToDateAndKeepWhatItHolds) {
  const Place place(GetParam());
  for (const std::string& statement : kVersion1) place.database()->run(statement);
  CalibrationStore store = place.calibrations();
  const Calibration old = store.get(3);
  EXPECT_EQ(old.machine.name, "Mill");
  EXPECT_EQ(old.taken, "2025-01-01T00:00:00Z");
  EXPECT_EQ(old.model, "model");
  EXPECT_EQ(old.inputs, (std::vector<std::pair<std::string, std::string>>{{"old.csv", "digits"}}));
  EXPECT_EQ(old.note, "");
  EXPECT_FALSE(old.closure);
  EXPECT_EQ(store.add(calibration("8", "2026-03-01T00:00:00Z", "1")).id, 4);
  EXPECT_EQ(schema_version(*place.database()), static_cast<int>(migrations().size()));
}

TEST_P(Stores, MakeTheSameTablesInOneGoAndVersionByVersion) {
  const Place place(GetParam());
  for (const std::string& statement : kVersion1) place.database()->run(statement);
  EXPECT_EQ(migrations()[0][2], kVersion1[2]) << "version 1 has been in use: it is never edited";
  EXPECT_EQ(migrations()[0][3], kVersion1[3]);
}

TEST_P(Stores, RefuseTheTablesOfALaterProgram) {
  const Place place(GetParam());
  place.calibrations().add(calibration("7", "2026-03-01T00:00:00Z", "1"));
  place.database()->run("UPDATE trunnion_schema SET version = 99");
  try {
    place.calibrations();
    FAIL() << "tables of version 99";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("is of version 99, this program knows 2"));
  }
}

TEST_P(Stores, UndoWhatWasNotCommitted) {
  const Place place(GetParam());
  CalibrationStore store = place.calibrations();
  const std::unique_ptr<Database> database = place.database();
  {
    const Transaction transaction(*database);
    database->run(
        "INSERT INTO trunnion_calibration (id, serial, machine_name, structure, taken, machine_file, model, "
        "model_sha256) VALUES (9, '', '', '', '', '', '', '')");
  }
  EXPECT_TRUE(store.list({}).empty());
}

INSTANTIATE_TEST_SUITE_P(In, Stores, ::testing::Values(std::getenv("TRUNNION_TEST_POSTGRES") != nullptr),
                         [](const auto& kind) { return kind.param ? "Postgres" : "AFile"; });

TEST(SqliteStore, RefusesADatabaseOfSomebodyElse) {
  const Place place(false);
  place.database()->run("CREATE TABLE customers (name TEXT)");
  EXPECT_THROW(place.database(), InputError);
}

TEST(SqliteStore, IsNotMadeByLookingForOne) {
  const Place place(false);
  EXPECT_THROW(open_database(place.store(), OpenFor::reading), InputError);
  EXPECT_FALSE(std::filesystem::exists(place.store()));
}

}  // namespace
}  // namespace trunnion
