# find_package(gms_ransac): the target gms_ransac::core, of an installation without ROS.
include(CMakeFindDependencyMacro)
find_dependency(OpenCV 4 COMPONENTS core imgproc imgcodecs features2d calib3d video)
find_dependency(Eigen3 3.3)
find_dependency(Threads)
include(${CMAKE_CURRENT_LIST_DIR}/gms_ransac-targets.cmake)
