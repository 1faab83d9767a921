// Where must the motors go so that the tool is at x, now? usage: controller HOST:PORT X_MM
#include <driftwise/client.h>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: controller HOST:PORT X_MM\n"), 2;
  const driftwise::client::Client driftwise(argv[1], "example controller");
  const auto target = driftwise.target({{"x_mm", std::atof(argv[2])}});
  if (!target) {  // no model serves, the pose lacks a coordinate, no daemon: hold still, say why
    std::fprintf(stderr, "%s: %s\n", target.error().reason.c_str(), target.error().message.c_str());
    return 5;
  }
  for (const auto& q : target->coordinates)
    std::printf("%s %.17g u90_nm %.1f\n", q.channel.c_str(), q.position_mm, q.u90_nm);
  for (const auto& flag : target->flags) std::printf("flag %s\n", flag.c_str());
}
