# How this project's targets are made: one place for warnings, sanitizers and install rules.

set(STEVEDORE_SANITIZE "" CACHE STRING "Sanitizers to build with, e.g. address,undefined or thread")

add_library(stevedore_options INTERFACE)
target_compile_options(stevedore_options INTERFACE -Wall -Wextra -Wconversion -Wshadow -Werror)
target_include_directories(stevedore_options INTERFACE ${CMAKE_SOURCE_DIR})
if(STEVEDORE_SANITIZE)
  target_compile_options(stevedore_options INTERFACE -fsanitize=${STEVEDORE_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(stevedore_options INTERFACE -fsanitize=${STEVEDORE_SANITIZE})
  # gcc 12 with a sanitizer sees uninitialized members in std::function and std::regex that are not
  target_compile_options(stevedore_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
endif()

# stevedore_library(NAME SOURCES... [PUBLIC libraries...]): a room's library.
function(stevedore_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;PUBLIC" ${ARGN})
  add_library(${name} STATIC ${arg_SOURCES})
  target_link_libraries(${name} PUBLIC ${arg_PUBLIC} PRIVATE stevedore_options)
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>)
endfunction()

# stevedore_program(NAME SOURCES... [LINK libraries...]): a program in bin/, installed.
function(stevedore_program name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE ${arg_LINK} stevedore_options)
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()

