#include "history/database.h"

#include "error.h"
#include "history/postgres/postgres_module.h"
#include "loaded_module.h"

namespace trunnion {

Transaction::Transaction(Database& database) : database_(database) { database_.begin_alone(); }

Transaction::~Transaction() {
  if (!open_) return;
  try {
    database_.run("ROLLBACK");
  } catch (const Error&) {  // the connection is gone, and with it the transaction
    open_ = false;
  }
}

void Transaction::commit() {
  database_.run("COMMIT");
  open_ = false;
}

std::unique_ptr<Database> open_database(const std::string& store, OpenFor purpose) {
  for (const char* scheme : {"postgresql://", "postgres://"})
    if (store.starts_with(scheme)) return open_postgres(store);
  return open_sqlite(store, purpose);
}

std::unique_ptr<Database> open_postgres(const std::string& uri) {
  const std::string module = module_path("trunnion_postgres", TRUNNION_LIBDIR);
  if (module.empty())
    throw InputError("postgresql://", "this program was built without PostgreSQL (libpq); name a file as the store");
  const auto open =
      reinterpret_cast<TrunnionPostgresOpen*>(module_function(module, kTrunnionPostgresOpen, "the PostgreSQL module"));
  return std::unique_ptr<Database>(open(uri.c_str()));
}

}  // namespace trunnion
