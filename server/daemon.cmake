# driftwised: included from server/CMakeLists.txt, after the rooms. The drivers and the store are added later in the
# tree; targets may be named before they exist.
add_executable(driftwised ${CMAKE_CURRENT_LIST_DIR}/main.cc ${CMAKE_CURRENT_LIST_DIR}/service_manager.cc
  ${CMAKE_CURRENT_LIST_DIR}/clean_log.cc ${CMAKE_CURRENT_LIST_DIR}/descriptor_limit.cc)
target_include_directories(driftwised PRIVATE ${PROJECT_SOURCE_DIR})
target_compile_definitions(driftwised PRIVATE DRIFTWISE_VERSION="${PROJECT_VERSION}")
target_link_libraries(driftwised PRIVATE
  driftwise_application driftwise_target_line driftwise_formats driftwise_rpc driftwise_web driftwise_storage
  driftwise_pi_gcs driftwise_keithley_2701 driftwise_interferometer_adapter driftwise_lds1000 driftwise_load_actuator
  driftwise_watlow_ez_zone
  driftwise_warnings CLI11::CLI11 spdlog::spdlog nlohmann_json::nlohmann_json)
