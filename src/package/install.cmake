# What `cmake --install` puts where; programs are installed by the folders that build them.
include(CMakePackageConfigHelpers)
set(_data ${CMAKE_INSTALL_DATADIR}/slipstep)
set(_package ${CMAKE_INSTALL_LIBDIR}/cmake/slipstep)

install(TARGETS ${_libraries} EXPORT slipstepTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/slipstep)
file(GLOB _headers CONFIGURE_DEPENDS include/*.h)
file(GLOB _policies CONFIGURE_DEPENDS training/policies/*.h5)
file(GLOB _python CONFIGURE_DEPENDS training/study/*.py examples/convert_mesh.py)
file(GLOB _options CONFIGURE_DEPENDS examples/*.opts)
install(FILES ${_headers} ${PROJECT_BINARY_DIR}/include/slipbuild.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/slipstep)
install(FILES ${_policies} DESTINATION ${_data}/policies)
# The library finds them relative to itself, so that an installed tree may be moved; in the build tree by a link beside
# it.
file(RELATIVE_PATH _lib_to_policies ${CMAKE_INSTALL_FULL_LIBDIR} ${CMAKE_INSTALL_FULL_DATADIR}/slipstep/policies)
target_compile_definitions(slipstep PRIVATE SLIPSTEP_LIB_TO_POLICIES="${_lib_to_policies}"
                           SLIPSTEP_INSTALLED_POLICIES="${CMAKE_INSTALL_FULL_DATADIR}/slipstep/policies")
set(_beside lib)
if(NOT BUILD_SHARED_LIBS) # beside the programs
  list(APPEND _beside bin tests)
endif()
foreach(_folder ${_beside})
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/${_folder})
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/training/policies ${PROJECT_BINARY_DIR}/${_folder}/slipstep-policies SYMBOLIC)
endforeach()
install(PROGRAMS ${_python} DESTINATION ${_data}/python)
# The Python package looks for the library two folders up. Programs in Python find it beside them, by a link.
install(DIRECTORY ${CMAKE_CURRENT_LIST_DIR}/slipstep DESTINATION ${CMAKE_INSTALL_LIBDIR}/python3 FILES_MATCHING PATTERN *.py PATTERN __pycache__ EXCLUDE)
file(RELATIVE_PATH _programs_to_package ${CMAKE_INSTALL_FULL_DATADIR}/slipstep/python ${CMAKE_INSTALL_FULL_LIBDIR}/python3/slipstep)
install(CODE "file(CREATE_LINK ${_programs_to_package} \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${_data}/python/slipstep\" SYMBOLIC)")
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/lib/python3)
file(CREATE_LINK ${CMAKE_CURRENT_LIST_DIR}/slipstep ${PROJECT_BINARY_DIR}/lib/python3/slipstep SYMBOLIC)
install(FILES ${_options} DESTINATION ${_data}/examples)
# One program for all programs in Python: slipstep NAME
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
file(CREATE_LINK ${CMAKE_CURRENT_LIST_DIR}/program.py ${PROJECT_BINARY_DIR}/bin/slipstep SYMBOLIC)
install(PROGRAMS ${CMAKE_CURRENT_LIST_DIR}/program.py DESTINATION ${CMAKE_INSTALL_BINDIR} RENAME slipstep)

# find_package(slipstep) gives slipstep::slipstep, shared unless BUILD_SHARED_LIBS is off, and slipstep::slipstep_static,
# with the PETSc that this was built against and no other.
set(SLIPSTEP_IMPORTED_TARGETS "")
foreach(_name ${SLIPSTEP_IMPORTED})
  string(TOUPPER ${_name} _upper)
  string(APPEND SLIPSTEP_IMPORTED_TARGETS "  _slipstep_import(${_name} \"${SLIPSTEP_${_upper}_LIBRARIES}\" \"${SLIPSTEP_${_upper}_INCLUDES}\")\n")
endforeach()
set(SLIPSTEP_PETSC_HEADER ${SLIPSTEP_PETSC_HEADERS}/petscversion.h)
install(EXPORT slipstepTargets NAMESPACE slipstep:: DESTINATION ${_package})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/slipstepConfig.cmake.in ${PROJECT_BINARY_DIR}/slipstepConfig.cmake
                              INSTALL_DESTINATION ${_package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/slipstepConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/slipstepConfig.cmake ${PROJECT_BINARY_DIR}/slipstepConfigVersion.cmake DESTINATION ${_package})

# pkg-config; paths relative to the file, so that an installed tree may be moved. PETSc is there by its paths: "Requires"
# would take whichever PETSc.pc is found first. With a static library only, all that it needs is in Libs.
set(SLIPSTEP_PC_CFLAGS "")
foreach(_folder ${SLIPSTEP_PETSC_INCLUDES})
  string(APPEND SLIPSTEP_PC_CFLAGS " -I${_folder}")
endforeach()
set(SLIPSTEP_PC_LIBS "-Wl,-rpath,${SLIPSTEP_PETSC_LIBDIR}")
list(JOIN SLIPSTEP_PETSC_LIBRARIES " " _words)
string(APPEND SLIPSTEP_PC_LIBS " ${_words}")
set(SLIPSTEP_PC_PRIVATE "")
foreach(_name ${SLIPSTEP_IMPORTED})
  if(NOT _name STREQUAL petsc)
    string(TOUPPER ${_name} _upper)
    list(APPEND SLIPSTEP_PC_PRIVATE ${SLIPSTEP_${_upper}_LIBRARIES})
  endif()
endforeach()
list(JOIN SLIPSTEP_PC_PRIVATE " " SLIPSTEP_PC_PRIVATE)
string(APPEND SLIPSTEP_PC_PRIVATE " -lm")
if(CMAKE_DL_LIBS)
  string(APPEND SLIPSTEP_PC_PRIVATE " -l${CMAKE_DL_LIBS}")
endif()
if(NOT BUILD_SHARED_LIBS)
  string(APPEND SLIPSTEP_PC_LIBS " ${SLIPSTEP_PC_PRIVATE}")
endif()
file(RELATIVE_PATH SLIPSTEP_PC_TO_PREFIX ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(${CMAKE_CURRENT_LIST_DIR}/slipstep.pc.in ${PROJECT_BINARY_DIR}/slipstep.pc @ONLY)
configure_file(${CMAKE_CURRENT_LIST_DIR}/sliptrain.pc.in ${PROJECT_BINARY_DIR}/sliptrain.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/slipstep.pc ${PROJECT_BINARY_DIR}/sliptrain.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
