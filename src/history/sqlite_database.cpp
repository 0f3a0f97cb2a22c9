#include <sqlite3.h>
#include <sys/stat.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "error.h"
#include "history/database.h"

namespace trunnion {
namespace {

constexpr std::chrono::seconds kPatience{60};  // for the other processes' transactions, of milliseconds each
constexpr std::chrono::milliseconds kPause{5};

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
};
struct Finalise {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};

class SqliteDatabase : public Database {
 public:
  SqliteDatabase(const std::string& path, OpenFor purpose) : path_(path) {
    if (path.empty()) throw UsageError("--store: a file or postgresql://… is wanted");
    check_place(purpose);
    sqlite3* database = nullptr;
    const int flags = SQLITE_OPEN_READWRITE | (purpose == OpenFor::adding ? SQLITE_OPEN_CREATE : 0);
    const std::string file = path.front() == '/' ? path : "./" + path;  // ":memory:" and "file:" are names like others
    const int status = sqlite3_open_v2(file.c_str(), &database, flags, nullptr);
    database_.reset(database);
    if (status != SQLITE_OK) fail("cannot be opened");
    sqlite3_extended_result_codes(database, 1);
    sqlite3_busy_timeout(database, static_cast<int>(std::chrono::milliseconds(kPatience).count()));
    run("PRAGMA foreign_keys = ON");
    run("PRAGMA synchronous = FULL");
    // In one statement, so that another process that makes the tables meanwhile is seen wholly or not at all.
    if (!run("SELECT 1 WHERE EXISTS (SELECT 1 FROM sqlite_master) AND NOT EXISTS "
             "(SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = 'trunnion_schema')")
             .empty())
      throw InputError(path_, "is no history of trunnion: it holds other tables");
    if (purpose == OpenFor::adding) use_write_ahead_log();
  }

  std::vector<Row> run(const std::string& text, const std::vector<Cell>& values = {}) override {
    sqlite3_stmt* prepared = nullptr;
    if (sqlite3_prepare_v2(database_.get(), text.c_str(), -1, &prepared, nullptr) != SQLITE_OK) fail(refusal());
    const std::unique_ptr<sqlite3_stmt, Finalise> statement(prepared);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const int index = sqlite3_bind_parameter_index(prepared, ("$" + std::to_string(k + 1)).c_str());
      if (index != 0 && values[k])
        sqlite3_bind_text64(prepared, index, values[k]->data(), values[k]->size(), SQLITE_TRANSIENT, SQLITE_UTF8);
    }
    std::vector<Row> rows;
    int status = 0;
    while ((status = sqlite3_step(prepared)) == SQLITE_ROW) {
      Row& row = rows.emplace_back();
      for (int column = 0; column < sqlite3_column_count(prepared); ++column) {
        const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(prepared, column));
        if (bytes == nullptr)
          row.emplace_back();
        else
          row.emplace_back(std::string(bytes, static_cast<std::size_t>(sqlite3_column_bytes(prepared, column))));
      }
    }
    if (status != SQLITE_DONE) fail(refusal());
    return rows;
  }

  void begin_alone() override { run("BEGIN IMMEDIATE"); }

  bool has_table(const std::string& name) override {
    return !run("SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = $1", {name}).empty();
  }

  const std::string& name() const override { return path_; }

 private:
  void check_place(OpenFor purpose) const {
    struct stat info {};
    if (::stat(path_.c_str(), &info) != 0) {
      if (errno == ENOENT && purpose == OpenFor::adding) return;
      throw InputError(path_, std::string("cannot be opened: ") + std::strerror(errno));
    }
    if (!S_ISREG(info.st_mode)) throw InputError(path_, "is no file; a history is one");
  }

  /// A change of the journal is refused at once, without waiting, while another process opens the file.
  void use_write_ahead_log() {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    for (;;) {
      try {
        run("PRAGMA journal_mode = WAL");
        return;
      } catch (const InputError&) {
        if ((sqlite3_errcode(database_.get()) & 0xff) != SQLITE_BUSY || std::chrono::steady_clock::now() > end) throw;
      }
      std::this_thread::sleep_for(kPause);
    }
  }

  std::string refusal() const {
    if (sqlite3_errcode(database_.get()) == SQLITE_NOTADB) return "is no history of trunnion";
    return "cannot be used";
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(path_, what + ": " + (database_ ? sqlite3_errmsg(database_.get()) : "out of memory"));
  }

  std::string path_;
  std::unique_ptr<sqlite3, CloseDatabase> database_;
};

}  // namespace

std::unique_ptr<Database> open_sqlite(const std::string& path, OpenFor purpose) {
  return std::make_unique<SqliteDatabase>(path, purpose);
}

}  // namespace trunnion
