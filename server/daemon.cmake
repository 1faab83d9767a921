# driftwised: included from server/CMakeLists.txt, after the rooms. The drivers and the store are added later in the
# tree; targets may be named before they exist.
add_executable(driftwised ${CMAKE_CURRENT_LIST_DIR}/main.cc ${CMAKE_CURRENT_LIST_DIR}/service_manager.cc
  ${CMAKE_CURRENT_LIST_DIR}/clean_log.cc ${CMAKE_CURRENT_LIST_DIR}/controller_claim.cc ${CMAKE_CURRENT_LIST_DIR}/descriptor_limit.cc ${CMAKE_CURRENT_LIST_DIR}/heap_upkeep.cc ${CMAKE_CURRENT_LIST_DIR}/kept_stop_file.cc
  ${CMAKE_CURRENT_LIST_DIR}/notice_file.cc ${CMAKE_CURRENT_LIST_DIR}/start_warnings.cc)
target_include_directories(driftwised PRIVATE ${PROJECT_SOURCE_DIR})
target_compile_definitions(driftwised PRIVATE DRIFTWISE_VERSION="${PROJECT_VERSION}")
target_link_libraries(driftwised PRIVATE
  driftwise_application driftwise_line driftwise_formats driftwise_rpc driftwise_web driftwise_storage driftwise_notify
  driftwise_devices driftwise_transport driftwise_locks
  driftwise_warnings CLI11::CLI11 spdlog::spdlog nlohmann_json::nlohmann_json)
