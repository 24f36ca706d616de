# plumbing(TARGET [EXCEPT FILE...]): most of the target runs a few times an image or less. At -O3 the compiler would
# spend a third longer on it, and nothing be faster. Nearly all that it reads are the headers of ROS, Eigen and OpenCV:
# several files together read them once. Files behind EXCEPT are optimised, each by itself.
option(GMS_RANSAC_UNITY "Compile several files at once, and common headers once: a short clean build (CMake 3.16)" ON)
function(plumbing target)
  cmake_parse_arguments(PARSE_ARGV 1 plumbing "" "" EXCEPT)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${GMS_RANSAC_UNITY} UNITY_BUILD_BATCH_SIZE 6)
  if(plumbing_EXCEPT)
    set_source_files_properties(${plumbing_EXCEPT} PROPERTIES
      COMPILE_FLAGS $<$<CONFIG:Release>:-O3> SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()

# shared_headers(TARGET HEADER...): headers of other packages that most files of the target read are compiled once.
# Files with flags of their own cannot use them.
function(shared_headers target)
  if(NOT GMS_RANSAC_UNITY OR CMAKE_VERSION VERSION_LESS 3.16)
    return()
  endif()
  target_precompile_headers(${target} PRIVATE ${ARGN})
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    get_source_file_property(own_flags ${source} COMPILE_FLAGS)
    if(own_flags)
      set_source_files_properties(${source} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
    endif()
  endforeach()
endfunction()
