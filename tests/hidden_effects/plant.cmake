# Effects hidden in the plants, which share no code with server/ (docs/diagnosis-plants.md).
add_library(driftwise_hidden_plants STATIC
  plants/plant_cases.cc
  plants/plant_judge.cc
  plants/plant_plans.cc
  plants/plant_run.cc)
target_include_directories(driftwise_hidden_plants PUBLIC ${PROJECT_SOURCE_DIR})
target_compile_definitions(driftwise_hidden_plants PRIVATE DRIFTWISE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
target_link_libraries(driftwise_hidden_plants
  PUBLIC driftwise_diagnosis driftwise_plant_campaign driftwise_plant
  PRIVATE driftwise_test_statistics driftwise_devices driftwise_formats driftwise_warnings)

add_executable(plant_sweep
  plants/plant_sweep_main.cc)
target_link_libraries(plant_sweep PRIVATE
  driftwise_hidden_plants driftwise_formats CLI11::CLI11 driftwise_warnings)

driftwise_test(hidden_effects_plant
  SOURCES
    plants/plant_separating_test.cc
    plants/plant_test.cc
    plants/plant_unexplained_test.cc
  LINKS driftwise_hidden_plants driftwise_diagnosis driftwise_formats
  LABELS hidden_effects
  TIMEOUT 300)

# What the daemon makes of a diagnosis, judged by the plant's truth.
if(TARGET driftwise_application)
  add_library(driftwise_hidden_accepted STATIC
    plants/plant_accept.cc)
  target_compile_definitions(driftwise_hidden_accepted PRIVATE DRIFTWISE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(driftwise_hidden_accepted
    PUBLIC driftwise_hidden_plants
    PRIVATE driftwise_served_truth driftwise_warnings)

  add_executable(plant_accept
    plants/plant_accept_main.cc)
  target_link_libraries(plant_accept PRIVATE driftwise_hidden_accepted driftwise_served_truth driftwise_warnings)

  driftwise_test(hidden_effects_accept
    SOURCES
      plants/plant_accept_test.cc
    LINKS driftwise_hidden_accepted
    LABELS hidden_effects
    TIMEOUT 300)
endif()
