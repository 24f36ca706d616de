# plumbing(TARGET [EXCEPT FILE...]): most of the target runs a few times an image or less. At -O3 the compiler would
# spend a third longer on it, and nothing be faster. Nearly all that it reads are the headers of ROS, Eigen and OpenCV:
# several files together read them once. What stands behind EXCEPT is optimised, each file by itself.
option(GMS_RANSAC_UNITY "Compile several files of the plumbing at once, for a short clean build (CMake 3.16)" ON)
function(plumbing target)
  cmake_parse_arguments(PARSE_ARGV 1 plumbing "" "" EXCEPT)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${GMS_RANSAC_UNITY} UNITY_BUILD_BATCH_SIZE 6)
  if(plumbing_EXCEPT)
    set_source_files_properties(${plumbing_EXCEPT} PROPERTIES
      COMPILE_FLAGS $<$<CONFIG:Release>:-O3> SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()
