#include "drivers/simulated/plant/file/make_plant.h"

#include <stdexcept>

#include "drivers/simulated/plant/file/plant_file.h"

namespace driftwise::simulated {
namespace {

template <class Parameters, class PlantOfKind>
std::unique_ptr<PlantOfKind> plant_of(const std::filesystem::path& file,
                                      const PlantOptions& options, const char* kind) {
  PlantParameters parameters = read_plant_file(file, options.overrides);
  auto* wanted = std::get_if<Parameters>(&parameters);
  if (wanted == nullptr) {
    throw PlantFileError(file.string() + ": plant.kind: found another kind, expected " + kind);
  }
  return std::make_unique<PlantOfKind>(std::move(*wanted), options.seed, options.epoch_ns);
}

std::unique_ptr<CellPlant> plant_of_any_kind(const std::filesystem::path& file,
                                             const PlantOptions& options) {
  PlantParameters parameters = read_plant_file(file, options.overrides);
  if (auto* axis = std::get_if<LinearAxisParameters>(&parameters)) {
    return std::make_unique<LinearAxisPlant>(std::move(*axis), options.seed, options.epoch_ns);
  }
  if (auto* two = std::get_if<TwoRobotsParameters>(&parameters)) {
    return std::make_unique<TwoRobotsPlant>(std::move(*two), options.seed, options.epoch_ns);
  }
  if (auto* tilting = std::get_if<MinAngleParameters>(&parameters)) {
    return std::make_unique<MinAnglePlant>(std::move(*tilting), options.seed, options.epoch_ns);
  }
  if (auto* cube = std::get_if<DeltaCubeParameters>(&parameters)) {
    return std::make_unique<DeltaCubePlant>(std::move(*cube), options.seed, options.epoch_ns);
  }
  return std::make_unique<MicroNanoPlant>(std::get<MicroNanoParameters>(std::move(parameters)),
                                          options.seed, options.epoch_ns);
}

}  // namespace

std::unique_ptr<CellPlant> make_any_plant(const std::filesystem::path& file,
                                          const PlantOptions& options) {
  auto plant = plant_of_any_kind(file, options);
  try {
    plant->check_voltages();
  } catch (const std::out_of_range& problem) {
    throw PlantFileError(file.string() + ": " + problem.what() + "; columns: truth.csv");
  }
  return plant;
}

std::unique_ptr<LinearAxisPlant> make_plant(const std::filesystem::path& file,
                                            const PlantOptions& options) {
  return plant_of<LinearAxisParameters, LinearAxisPlant>(file, options, "linear-axis");
}

std::unique_ptr<MicroNanoPlant> make_micro_nano_plant(const std::filesystem::path& file,
                                                      const PlantOptions& options) {
  return plant_of<MicroNanoParameters, MicroNanoPlant>(file, options, "micro-nano");
}

std::unique_ptr<MinAnglePlant> make_min_angle_plant(const std::filesystem::path& file,
                                                    const PlantOptions& options) {
  return plant_of<MinAngleParameters, MinAnglePlant>(file, options, "min-angle");
}

std::unique_ptr<TwoRobotsPlant> make_two_robots_plant(const std::filesystem::path& file,
                                                      const PlantOptions& options) {
  return plant_of<TwoRobotsParameters, TwoRobotsPlant>(file, options, "two-robots");
}

std::unique_ptr<DeltaCubePlant> make_delta_cube_plant(const std::filesystem::path& file,
                                                      const PlantOptions& options) {
  return plant_of<DeltaCubeParameters, DeltaCubePlant>(file, options, "delta-cube");
}

}  // namespace driftwise::simulated
