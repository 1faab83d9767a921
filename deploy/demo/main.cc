//   driftwise-demo-report linear-axis|micro-nano fits|proof FOLDER
//   driftwise-demo-report min-angle rectification|tables FOLDER
//   driftwise-demo-report two-robots tables|contacts FOLDER
//   driftwise-demo-report delta-cube-2 join|methods FOLDER
//   driftwise-demo-report hidden FOLDER     exit code 1: something hidden was not named

#include <cstdio>
#include <exception>
#include <string>

#include "deploy/demo/reports.h"

int main(int argc, char** argv) try {
  using namespace driftwise::demo;
  const std::string robot = argc == 4 ? argv[1] : "", what = argc == 4 ? argv[2] : "";
  if (robot == "linear-axis" && what == "fits") return print_linear_axis_fits(argv[3]), 0;
  if (robot == "linear-axis" && what == "proof") return print_linear_axis_proof(argv[3]), 0;
  if (robot == "micro-nano" && what == "fits") return print_micro_nano_fits(argv[3]), 0;
  if (robot == "micro-nano" && what == "proof") return print_micro_nano_proof(argv[3]), 0;
  if (robot == "min-angle" && what == "rectification")
    return print_min_angle_rectification(argv[3]), 0;
  if (robot == "min-angle" && what == "tables") return print_min_angle_tables(argv[3]), 0;
  if (robot == "two-robots" && what == "contacts") return print_two_robots_contacts(argv[3]), 0;
  if (robot == "two-robots" && what == "tables") return print_two_robots_tables(argv[3]), 0;
  if (robot == "delta-cube-2" && what == "join") return print_delta_cube_join(argv[3]), 0;
  if (robot == "delta-cube-2" && what == "methods") return print_delta_cube_methods(argv[3]), 0;
  if (argc == 3 && std::string(argv[1]) == "hidden") return print_hidden(argv[2]) ? 0 : 1;
  std::fprintf(stderr,
               "usage: driftwise-demo-report linear-axis|micro-nano fits|proof FOLDER\n"
               "       driftwise-demo-report min-angle rectification|tables FOLDER\n"
               "       driftwise-demo-report two-robots tables|contacts FOLDER\n"
               "       driftwise-demo-report delta-cube-2 join|methods FOLDER\n"
               "       driftwise-demo-report hidden FOLDER\n");
  return 2;
} catch (const std::exception& error) {
  std::fprintf(stderr, "driftwise-demo-report: %s\n", error.what());
  return 3;
}
