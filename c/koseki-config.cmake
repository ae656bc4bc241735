# find_package(koseki), then target_link_libraries(... koseki::koseki), or koseki::static.
get_filename_component(KOSEKI_PREFIX "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
if(NOT TARGET koseki::koseki)
  add_library(koseki::koseki SHARED IMPORTED)
  set_target_properties(koseki::koseki PROPERTIES
    IMPORTED_LOCATION "${KOSEKI_PREFIX}/lib/libkoseki.so"
    IMPORTED_NO_SONAME ON
    INTERFACE_INCLUDE_DIRECTORIES "${KOSEKI_PREFIX}/include")
  add_library(koseki::static STATIC IMPORTED)
  set_target_properties(koseki::static PROPERTIES
    IMPORTED_LOCATION "${KOSEKI_PREFIX}/lib/libkoseki.a"
    INTERFACE_LINK_LIBRARIES "pthread;dl;m"
    INTERFACE_INCLUDE_DIRECTORIES "${KOSEKI_PREFIX}/include")
endif()
