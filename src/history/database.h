#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace trunnion {

/// One value of a row as text; empty: NULL.
using Cell = std::optional<std::string>;
using Row = std::vector<Cell>;

/// A relational database, seen as far as SQLite and PostgreSQL agree. Not for two threads at once.
class Database {
 public:
  virtual ~Database() = default;
  Database() = default;
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Runs one statement and returns its rows; $1, $2 … in it stand for `values`. Throws InputError naming the store and
  /// what the database said.
  virtual std::vector<Row> run(const std::string& statement, const std::vector<Cell>& values = {}) = 0;
  /// Begins a transaction that no other writer takes part in, after waiting for theirs to end.
  virtual void begin_alone() = 0;
  virtual bool has_table(const std::string& name) = 0;
  /// As messages call it; without a password.
  virtual const std::string& name() const = 0;
};

/// What happens between begin_alone() and commit() happens whole or not at all: without commit(), not at all.
class Transaction {
 public:
  explicit Transaction(Database& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  Database& database_;
  bool open_ = true;
};

/// Whether a store that is missing is an error or is made.
enum class OpenFor { reading, adding };

/// A store by its name: `postgresql://…` (or `postgres://…`) is a database of a server, anything else an SQLite file,
/// which is made where it is missing and `purpose` is adding. Throws InputError for one that cannot be opened.
std::unique_ptr<Database> open_database(const std::string& store, OpenFor purpose);

/// The SQLite file at `path`, which must be Trunnion's or empty: write-ahead log, every commit on the disk before it
/// returns; waits up to a minute for other processes.
std::unique_ptr<Database> open_sqlite(const std::string& path, OpenFor purpose);

/// The PostgreSQL database of a connection URI, by libpq in the module trunnion_postgres, which is loaded for it.
std::unique_ptr<Database> open_postgres(const std::string& uri);

}  // namespace trunnion
