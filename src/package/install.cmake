# What `cmake --install` puts where; programs are installed by the folders that build them.
include(CMakePackageConfigHelpers)
set(_data ${CMAKE_INSTALL_DATADIR}/slipstep)
set(_package ${CMAKE_INSTALL_LIBDIR}/cmake/slipstep)

install(TARGETS slipstep EXPORT slipstepTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/slipstep)
file(GLOB _headers CONFIGURE_DEPENDS include/*.h)
file(GLOB _policies CONFIGURE_DEPENDS training/policies/*.h5)
file(GLOB _python CONFIGURE_DEPENDS output/*.py training/*.py)
file(GLOB _options CONFIGURE_DEPENDS examples/*.opts)
install(FILES ${_headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/slipstep)
install(FILES ${_policies} DESTINATION ${_data}/policies)
# The library finds them relative to itself, so that an installed tree may be moved; in the build tree by a link beside
# it.
file(RELATIVE_PATH _lib_to_policies ${CMAKE_INSTALL_FULL_LIBDIR} ${CMAKE_INSTALL_FULL_DATADIR}/slipstep/policies)
target_compile_definitions(slipstep PRIVATE SLIPSTEP_LIB_TO_POLICIES="${_lib_to_policies}")
file(MAKE_DIRECTORY ${CMAKE_LIBRARY_OUTPUT_DIRECTORY})
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/training/policies ${CMAKE_LIBRARY_OUTPUT_DIRECTORY}/slipstep-policies SYMBOLIC)
install(PROGRAMS ${_python} DESTINATION ${_data}/python)
install(FILES ${_options} DESTINATION ${_data}/examples)

# find_package(slipstep) gives slipstep::slipstep. PETSc is looked up again: where pkg-config finds it, else where it
# was here.
pkg_get_variable(SLIPSTEP_PETSC_PCDIR PETSc pcfiledir)
install(EXPORT slipstepTargets NAMESPACE slipstep:: DESTINATION ${_package})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/slipstepConfig.cmake.in ${PROJECT_BINARY_DIR}/slipstepConfig.cmake
                              INSTALL_DESTINATION ${_package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/slipstepConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/slipstepConfig.cmake ${PROJECT_BINARY_DIR}/slipstepConfigVersion.cmake DESTINATION ${_package})

# pkg-config; paths relative to the file, so that an installed tree may be moved.
file(RELATIVE_PATH SLIPSTEP_PC_TO_PREFIX ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(${CMAKE_CURRENT_LIST_DIR}/slipstep.pc.in ${PROJECT_BINARY_DIR}/slipstep.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/slipstep.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
