#include "storage/chain/chain_rows.h"

#include "storage/chain/value_bytes.h"

namespace driftwise::storage {

const std::string kChainRoot(digest::kSha256Bytes, '\0');

std::string chain_head(digest::Sha256& sha, const std::string& before, std::int64_t number,
                       const std::string& what, const std::string& bytes) {
  std::string own;
  add_integer(own, number);
  add_text(own, what);
  return sha.begin().add(before).add(own).add(bytes).finish();
}

void append_entry(Database& db, digest::Sha256& sha, const std::string& what,
                  const std::string& bytes) {
  const ChainEntry last = newest_entry(db);
  const std::int64_t number = last.number + 1;
  const std::string head =
      chain_head(sha, last.number == 0 ? kChainRoot : last.head, number, what, bytes);
  Query(db, "INSERT INTO chain (entry_id, what, bytes, head) VALUES (?, ?, ?, ?)")
      .bind(number, what, Bytes{bytes}, Bytes{head})
      .run();
}

ChainEntry newest_entry(Database& db) {
  Query query(db, "SELECT entry_id, what, head FROM chain ORDER BY entry_id DESC LIMIT 1");
  if (!query.row()) return {};
  return {query.integer(0), query.text(1), {}, query.bytes(2)};
}

std::optional<ChainEntry> read_entry(Database& db, std::int64_t number) {
  Query query(db, "SELECT entry_id, what, bytes, head FROM chain WHERE entry_id = ?");
  if (!query.bind(number).row()) return std::nullopt;
  return ChainEntry{query.integer(0), query.text(1), query.bytes(2), query.bytes(3)};
}

ChainLayout newest_layout(Database& db, int kind) {
  Query query(db,
              "SELECT CAST(bytes AS TEXT), entry_id FROM chain WHERE what = 'layout' ORDER BY "
              "entry_id DESC");
  const std::string wanted = std::to_string(kind) + " ";
  while (query.row()) {
    const std::string text = query.text(0);
    if (text.starts_with(wanted)) return {text, query.integer(1)};
  }
  return {};
}

}  // namespace driftwise::storage
