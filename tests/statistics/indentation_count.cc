// Counts of the indentation's decisions on the two robots' plant, in process: false contacts and
// alignments. docs/indentation.md has the figures.

#include <CLI/CLI.hpp>
#include <cstdio>

#include "tests/statistics/touching_robots.h"

int main(int argc, char** argv) {
  using namespace driftwise::statistics;
  int approaches = 1000, cells = 20, contacts = 200;
  std::uint64_t seed = 1;
  CLI::App app{"Counts false contacts, and alignments of random substrates"};
  app.add_option("--approaches", approaches, "without contact, 40 steps each (default 1000)");
  app.add_option("--contacts", contacts, "approaches that touch (default 200)");
  app.add_option("--cells", cells, "alignments (default 20)");
  app.add_option("--seed", seed, "of the first (default 1)");
  CLI11_PARSE(app, argc, argv);

  int accepted = 0;
  for (int i = 0; i < cells; ++i) {
    TouchingRobots robots(seed + static_cast<std::uint64_t>(i));
    const auto a = align(robots);
    accepted += a.accepted && a.record.corrections <= 3;
    std::printf(
        "cell %2d: substrate %6.0f %6.0f arcsec, %d corrections, contacts agree to %4.0f nm, at "
        "the "
        "truth to %4.0f nm %s\n",
        i + 1, a.drawn_rx_arcsec, a.drawn_ry_arcsec, a.record.corrections, a.record.spread_nm,
        a.left_nm, a.trouble.c_str());
    std::fflush(stdout);
  }
  if (cells > 0)
    std::printf("aligned to 500 nm in at most 3 corrections: %d of %d\n", accepted, cells);
  if (contacts > 0) {
    const auto c = count_contacts(seed, contacts);
    std::printf(
        "contacts: %d of %d approaches, told at the first move that touches %d, the second %d, "
        "third %d, fourth %d, later %d, with nothing touched %d; at most %.1f mN\n",
        c.contacts, c.approaches, c.moves[0], c.moves[1], c.moves[2], c.moves[3], c.later, c.before,
        c.largest_force_mn);
    for (const auto& overlaps : c.late_overlap_nm) {
      std::printf("beyond the second move; overlap after each, nm:");
      for (const double nm : overlaps) std::printf(" %.0f", nm);
      std::printf("\n");
    }
  }
  if (approaches > 0) {
    const auto c = count_false_contacts(seed, approaches);
    std::printf(
        "approaches without contact: %d of 40 steps, %d knocks, %.1f h, the room changed by "
        "%.2f K: false contacts %d, aborts %d\n",
        c.approaches, c.knocks, c.hours, c.room_change_k, c.contacts, c.aborts);
  }
  return 0;
}
