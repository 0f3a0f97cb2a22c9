#pragma once

namespace trunnion {
class Database;
}

/// What the module trunnion_postgres exports: the database of a connection URI, the caller's to delete. Throws
/// InputError where the server does not answer or refuses.
extern "C" using TrunnionPostgresOpen = trunnion::Database * (const char* uri);
inline constexpr char kTrunnionPostgresOpen[] = "trunnion_postgres_open";
