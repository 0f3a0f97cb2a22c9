#include <libpq-fe.h>

#include <algorithm>

#include "error.h"
#include "history/database.h"
#include "history/postgres/postgres_module.h"

namespace trunnion {
namespace {

struct Finish {
  void operator()(PGconn* connection) const { PQfinish(connection); }
};
struct Clear {
  void operator()(PGresult* result) const { PQclear(result); }
};

/// A message of the server on one line.
std::string one_line(const char* message) {
  std::string text = message;
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::ranges::replace(text, '\n', ' ');
  return text;
}

class PostgresDatabase : public Database {
 public:
  explicit PostgresDatabase(const char* uri) : connection_(PQconnectdb(uri)) {
    const auto told = [](const char* text) { return std::string(text == nullptr ? "" : text); };
    name_ = "postgresql://" + told(PQhost(connection_.get())) + "/" + told(PQdb(connection_.get()));
    if (PQstatus(connection_.get()) != CONNECTION_OK)
      throw InputError(name_, "cannot be opened: " + one_line(PQerrorMessage(connection_.get())));
    PQsetClientEncoding(connection_.get(), "UTF8");
    run("SET client_min_messages = warning");
  }

  std::vector<Row> run(const std::string& statement, const std::vector<Cell>& values = {}) override {
    std::vector<const char*> texts;
    for (const Cell& value : values) texts.push_back(value ? value->c_str() : nullptr);
    const std::unique_ptr<PGresult, Clear> result(PQexecParams(connection_.get(), statement.c_str(),
                                                               static_cast<int>(texts.size()), nullptr, texts.data(),
                                                               nullptr, nullptr, 0));
    const ExecStatusType status = PQresultStatus(result.get());
    if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK)
      throw InputError(name_, "cannot be used: " + one_line(PQerrorMessage(connection_.get())));
    std::vector<Row> rows;
    for (int r = 0; r < PQntuples(result.get()); ++r) {
      Row& row = rows.emplace_back();
      for (int c = 0; c < PQnfields(result.get()); ++c)
        row.push_back(PQgetisnull(result.get(), r, c) != 0
                          ? Cell()
                          : Cell(std::string(PQgetvalue(result.get(), r, c),
                                             static_cast<std::size_t>(PQgetlength(result.get(), r, c)))));
    }
    return rows;
  }

  void begin_alone() override {
    run("BEGIN");
    run("SELECT pg_advisory_xact_lock(hashtext('trunnion history'))");
  }

  bool has_table(const std::string& name) override {
    return !run("SELECT 1 FROM information_schema.tables WHERE table_schema = current_schema() AND table_name = $1",
                {name})
                .empty();
  }

  const std::string& name() const override { return name_; }

 private:
  std::unique_ptr<PGconn, Finish> connection_;
  std::string name_;
};

}  // namespace
}  // namespace trunnion

extern "C" __attribute__((visibility("default"))) trunnion::Database* trunnion_postgres_open(const char* uri) {
  return new trunnion::PostgresDatabase(uri);
}
