# generate_parameters(core|node): has <gms_ransac/PART_parameters.h> made of the one table of parameters, in the folder
# `generated` of the build, and sets PART_parameters to its path.
get_filename_component(parameter_table ${CMAKE_CURRENT_LIST_DIR}/../cfg/parameters.py ABSOLUTE)
get_filename_component(parameter_generator ${CMAKE_CURRENT_LIST_DIR}/../scripts/generate_parameters.py ABSOLUTE)
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/generated/gms_ransac)
function(generate_parameters part)
  set(header ${PROJECT_BINARY_DIR}/generated/gms_ransac/${part}_parameters.h)
  add_custom_command(OUTPUT ${header}
    COMMAND ${PYTHON_EXECUTABLE} ${parameter_generator} ${part} ${header}
    DEPENDS ${parameter_table} ${parameter_generator})
  add_custom_target(${PROJECT_NAME}_${part}_parameters DEPENDS ${header})  # scripts/lint wants the headers alone
  set(${part}_parameters ${header} PARENT_SCOPE)
endfunction()
