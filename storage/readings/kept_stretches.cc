#include "storage/readings/kept_stretches.h"

#include <algorithm>
#include <iterator>

namespace driftwise::storage {

void KeptStretches::add(std::int64_t from_ns, std::int64_t to_ns) {
  from_ns -= kAroundAttempt_ns;
  to_ns += kAroundAttempt_ns;
  auto at = ends_.upper_bound(from_ns);
  if (at != ends_.begin() && std::prev(at)->second >= from_ns) {
    at = std::prev(at);
    at->second = std::max(at->second, to_ns);
  } else {
    at = ends_.emplace_hint(at, from_ns, to_ns);
  }
  for (auto next = std::next(at); next != ends_.end() && next->first <= at->second;
       next = ends_.erase(next))
    at->second = std::max(at->second, next->second);
}

bool KeptStretches::is_within(std::int64_t from_ns, std::int64_t to_ns) const {
  const auto after = ends_.upper_bound(to_ns);
  return after != ends_.begin() && std::prev(after)->second >= from_ns;
}

void KeptStretches::read_on(Session& session) {
  const auto read = [&](const char* sql, std::int64_t& last) {
    Query query(session.db, sql);
    query.bind(last);
    while (query.row()) {
      last = query.integer(0);
      if (query.integer(3) == 0) add(query.integer(1), query.integer(2));
    }
  };
  read("SELECT attempt_id, started_ns, ended_ns, 0 FROM attempt WHERE attempt_id > ? ORDER BY 1",
       attempt_);
  read(
      "SELECT datum_id, opened_ns, opened_ns, EXISTS (SELECT 1 FROM imported_file f WHERE "
      "f.run_id = d.run_id) FROM datum d WHERE datum_id > ? ORDER BY 1",
      datum_);
  read(
      "SELECT point_id, measured_ns, measured_ns, EXISTS (SELECT 1 FROM imported_file f WHERE "
      "f.run_id = p.run_id) FROM point p WHERE point_id > ? ORDER BY 1",
      point_);
}

}  // namespace driftwise::storage
