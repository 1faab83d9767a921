# Where the programs' companions are installed, and the Debian package: `cpack -G DEB` in the build folder.
install(FILES ${CMAKE_CURRENT_LIST_DIR}/systemd/driftwised@.service DESTINATION lib/systemd/system COMPONENT programs)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/systemd/serial.conf DESTINATION ${CMAKE_INSTALL_DATADIR}/driftwise/systemd COMPONENT programs)
install(DIRECTORY ${CMAKE_CURRENT_LIST_DIR}/monitoring DESTINATION ${CMAKE_INSTALL_DATADIR}/driftwise COMPONENT programs)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/systemd/driftwise.sysusers.conf DESTINATION lib/sysusers.d RENAME driftwise.conf
  COMPONENT programs)
install(DIRECTORY ${CMAKE_CURRENT_LIST_DIR}/cells DESTINATION ${CMAKE_INSTALL_DATADIR}/driftwise COMPONENT programs)
install(DIRECTORY ${CMAKE_CURRENT_LIST_DIR}/mappings DESTINATION ${CMAKE_INSTALL_DATADIR}/driftwise COMPONENT programs)

set(CPACK_PACKAGE_NAME driftwise)
set(CPACK_PACKAGE_VENDOR Driftwise)
set(CPACK_PACKAGE_CONTACT "Driftwise <driftwise@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_GENERATOR DEB)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "openssl")  # driftwise cert
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_LIST_DIR}/systemd/postinst ${CMAKE_CURRENT_LIST_DIR}/systemd/prerm
  ${CMAKE_CURRENT_LIST_DIR}/systemd/postrm)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ALL_COMPONENTS_IN_ONE)
set(CPACK_COMPONENTS_ALL programs web)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
include(CPack)
